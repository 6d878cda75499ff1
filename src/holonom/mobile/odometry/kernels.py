"""Loops of odometry, compiled: increments of the base to poses, with covariance and with sensitivities."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.trace.code.compiled import TRIG_FLAGS, select, sincos
from holonom.trace.code.loops import loop

__all__ = ["all_finite", "integrate_into", "propagate_into", "sensitivities_into"]


LANES = 64
SMALL = 1e-4  # turn of one step, rad, below which the chord's length is its series


@loop(error_model="numpy")
def all_finite(rows: Array) -> bool:
    """Whether no number of (N, m) is NaN or infinite."""
    for k in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            if not np.isfinite(rows[k, j]):
                return False
    return True


@loop(error_model="numpy")
def _chord(turn: float) -> tuple[float, float]:
    """Chord over arc of a turn, `sin(turn/2) / (turn/2)`, and its derivative by the turn."""
    half = 0.5 * turn
    if abs(turn) < SMALL:
        return 1.0 - half * half / 6.0, -half / 6.0
    ratio = np.sin(half) / half
    return ratio, 0.5 * (np.cos(half) - ratio) / half


@loop(nogil=True, error_model="numpy", fastmath=TRIG_FLAGS)
def integrate_into(features: Array, M: Array, start: Array, share: float, exact: bool, poses: Array) -> None:
    """Add up increments `M features[k]` (3,) in the robot frame from `start` (3,); `poses` (N, 3) follow each one.

    `share` of the turn comes before the straight part; with `exact` that part is the chord of an arc. Block by block:
    headings one after the other, sines and cosines side by side, places one after the other.
    """
    n, m = features.shape
    x, y, theta = start
    step = np.empty((LANES, 2))
    turn, angle, c, s = np.zeros(LANES), np.zeros(LANES), np.zeros(LANES), np.zeros(LANES)
    for first in range(0, n, LANES):
        count = min(LANES, n - first)
        for k in range(count):
            dx = dy = dtheta = 0.0
            for j in range(m):
                f = features[first + k, j]
                dx += M[0, j] * f
                dy += M[1, j] * f
                dtheta += M[2, j] * f
            step[k, 0] = dx
            step[k, 1] = dy
            turn[k] = dtheta
            angle[k] = theta + share * dtheta
            theta += dtheta
            poses[first + k, 2] = theta
        for k in range(LANES):
            s[k], c[k] = sincos(angle[k])
        if exact:
            for k in range(LANES):
                half = 0.5 * turn[k]
                near = abs(turn[k]) < SMALL
                scale = select(near, 1.0 - half * half / 6.0, sincos(half)[0] / select(near, 1.0, half))
                s[k] *= scale
                c[k] *= scale
        for k in range(count):
            x += c[k] * step[k, 0] - s[k] * step[k, 1]
            y += s[k] * step[k, 0] + c[k] * step[k, 1]
            poses[first + k, 0] = x
            poses[first + k, 1] = y


@loop(error_model="numpy")
def step_jacobians(
    theta: float, increment: Array, share: float, exact: bool, by_pose: Array, by_increment: Array
) -> None:
    """Derivatives (3, 3) of the pose behind one step by the pose before it and by the increment."""
    turn = increment[2]
    scale, slope = _chord(turn) if exact else (1.0, 0.0)
    c, s = np.cos(theta + share * turn), np.sin(theta + share * turn)
    px = c * increment[0] - s * increment[1]
    py = s * increment[0] + c * increment[1]
    by_pose[:] = 0.0
    by_pose[0, 0] = by_pose[1, 1] = by_pose[2, 2] = 1.0
    by_pose[0, 2] = -scale * py
    by_pose[1, 2] = scale * px
    by_increment[0, 0] = scale * c
    by_increment[0, 1] = -scale * s
    by_increment[1, 0] = scale * s
    by_increment[1, 1] = scale * c
    by_increment[0, 2] = -share * scale * py + slope * px
    by_increment[1, 2] = share * scale * px + slope * py
    by_increment[2, 0] = by_increment[2, 1] = 0.0
    by_increment[2, 2] = 1.0


@loop(error_model="numpy")
def propagate_into(
    increments: Array,
    noise: Array,
    start: Array,
    covariance: Array,
    share: float,
    exact: bool,
    poses: Array,
    out: Array,
) -> None:
    """Poses (N, 3) and their covariances `out` (N, 3, 3), from `covariance` (3, 3) and that of each increment."""
    integrate_into(increments, np.eye(3), start, share, exact, poses)
    F, G = np.empty((3, 3)), np.empty((3, 3))
    P, half = covariance.copy(), np.empty((3, 3))
    theta = start[2]
    for k in range(increments.shape[0]):
        step_jacobians(theta, increments[k], share, exact, F, G)
        _congruence(F, P, half, out[k])
        P[:] = out[k]
        _congruence(G, noise[k], half, out[k])
        P += out[k]
        out[k] = P
        theta += increments[k, 2]


@loop(error_model="numpy")
def _congruence(A: Array, S: Array, half: Array, out: Array) -> None:
    """`out = A S A^T`, 3 x 3, by way of `half`."""
    for i in range(3):
        for j in range(3):
            half[i, j] = A[i, 0] * S[0, j] + A[i, 1] * S[1, j] + A[i, 2] * S[2, j]
    for i in range(3):
        for j in range(3):
            out[i, j] = half[i, 0] * A[j, 0] + half[i, 1] * A[j, 1] + half[i, 2] * A[j, 2]


@loop(error_model="numpy")
def sensitivities_into(
    increments: Array, slopes: Array, start: Array, share: float, exact: bool, poses: Array, out: Array
) -> None:
    """Poses (N, 3) of increments (N, 3), and their derivatives `out` (N, 3, p) from those of the increments."""
    n, p = slopes.shape[0], slopes.shape[2]
    x, y, theta = start
    D = np.zeros((2, p))  # derivatives of x and y
    turned = np.zeros(p)  # of theta
    for k in range(n):
        dx, dy, turn = increments[k]
        scale, slope = _chord(turn) if exact else (1.0, 0.0)
        angle = theta + share * turn
        c, s = np.cos(angle), np.sin(angle)
        px, py = c * dx - s * dy, s * dx + c * dy
        for j in range(p):
            by_x, by_y, by_turn = slopes[k, 0, j], slopes[k, 1, j], slopes[k, 2, j]
            by_angle = turned[j] + share * by_turn
            D[0, j] += scale * (c * by_x - s * by_y - py * by_angle) + slope * px * by_turn
            D[1, j] += scale * (s * by_x + c * by_y + px * by_angle) + slope * py * by_turn
            turned[j] += by_turn
            out[k, 2, j] = turned[j]
        x += scale * px
        y += scale * py
        theta += turn
        poses[k, 0] = x
        poses[k, 1] = y
        poses[k, 2] = theta
        out[k, :2] = D
