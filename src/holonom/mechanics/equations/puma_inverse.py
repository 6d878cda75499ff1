"""Closed-form inverse geometry of arms built like the Puma 560 (specification 1.3; Paul & Zhang 1986; Corke).

Standard DH with alpha = (90, 0, -90, 90, -90, 0) deg, a1 = a4 = a5 = a6 = 0, d2 + d3 the lateral shoulder offset,
any a2, a3, d1, d4, d6. Nothing assumes a3 = 0.

Wrist centre in the waist's plane: x + i y = (r - i d3) e^(i q1), r = +- sqrt(x^2 + y^2 - d3^2);
r + i z = e^(i q2) (a2 + L e^(i psi)), L = |a3 + i d4|, psi = q3 + atan2(d4, a3);
R_36 = Rz(q4) Ry(-q5) Rz(q6).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from holonom.mechanics.equations.vectors import Vector
from holonom.model import ArmModel
from holonom.trace import Condition, Number, atan2, cos, less, maximum, select, sin, sqrt

__all__ = [
    "BRANCHES",
    "LIMIT",
    "OK",
    "SINGULAR",
    "UNREACHABLE",
    "PumaGeometry",
    "puma_geometry",
    "puma_inverse",
]

OK, UNREACHABLE, LIMIT, SINGULAR = 0, 1, 2, 3
BRANCHES = tuple(
    f"{shoulder} {elbow} {wrist}"
    for shoulder in ("righty", "lefty")
    for elbow in ("above", "below")
    for wrist in ("noflip", "flip")
)
SINGULAR_SINE = 1e-9
"""|sin q5| below which only q4 + q6 is defined."""
REACH_TOLERANCE = 1e-12
"""Square of a length (m2) by which rounding may leave the workspace."""
LIMIT_TOLERANCE = 1e-9
"""Angle (rad) by which rounding may pass a joint limit."""


class PumaGeometry(NamedTuple):
    """Lengths (m) of the table above and the joint limits (rad)."""

    d1: float
    a2: float
    a3: float
    d3: float
    d4: float
    d6: float
    lower: tuple[float, ...]
    upper: tuple[float, ...]


def puma_geometry(model: ArmModel) -> PumaGeometry | None:
    """Return the lengths if the arm is built like a Puma, else None."""
    if len(model.joints) != 6 or any(j.kind != "revolute" for j in model.joints):
        return None
    after = np.array([j.after for j in model.joints])
    before = np.array([j.before for j in model.joints])
    quarter, none = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])  # third row of Rot(x, 90 deg), Rot(x, 0)
    turns = [quarter, none, -quarter, quarter, -quarter, none]
    shape = np.array_equal(before, np.tile(np.eye(4), (6, 1, 1))) and all(
        np.allclose(T[2, :3], turn, atol=1e-12) and np.allclose(T[:3, 0], [1.0, 0.0, 0.0], atol=1e-12)
        for T, turn in zip(after, turns, strict=True)
    )
    a, d = after[:, 0, 3], after[:, 2, 3]
    if not shape or np.any(a[[0, 3, 4, 5]]) or d[4] or a[1] <= 0.0 or d[3] <= 0.0:
        return None
    return PumaGeometry(
        d1=float(d[0]), a2=float(a[1]), a3=float(a[2]), d3=float(d[1] + d[2]), d4=float(d[3]), d6=float(d[5]),
        lower=tuple(j.limits.lower for j in model.joints), upper=tuple(j.limits.upper for j in model.joints),
    )  # fmt: skip


def puma_inverse(geometry: PumaGeometry, T: Vector) -> tuple[list[Number], list[Number]]:
    """All eight branches for the pose T_06 (16 numbers, row by row): joints (8 x 6) and status (8).

    The order is `BRANCHES`. An unreachable branch holds the joints of the nearest reachable wrist position in its
    own plane; a singular one has q4 = 0. Angles are wrapped into the limits where a whole turn allows it.
    """
    k = geometry
    x, y, z = (T[3] - k.d6 * T[2], T[7] - k.d6 * T[6], T[11] - k.d6 * T[10] - k.d1)
    lateral = x * x + y * y
    r_square = lateral - k.d3 * k.d3
    reach_1 = less(r_square, -REACH_TOLERANCE)
    r_positive = sqrt(maximum(r_square, 0.0))
    azimuth = atan2(y, x)
    length = math.hypot(k.a3, k.d4)
    offset = math.atan2(k.d4, k.a3)
    lower_arm = (r_positive * r_positive + z * z - (k.a2 * k.a2 + length * length)) * (0.5 / k.a2)
    sine_square = length * length - lower_arm * lower_arm
    reach_3 = less(sine_square, -REACH_TOLERANCE)
    span = sqrt(maximum(sine_square, 0.0))
    bend = atan2(span, lower_arm)
    unreachable = reach_1 | reach_3

    joints: list[Number] = []
    status: list[Number] = []
    for side in (1.0, -1.0):
        r = side * r_positive
        q1 = azimuth + atan2(k.d3, r)
        c1, s1 = cos(q1), sin(q1)
        for above in (1.0, -1.0):
            sign = -side * above
            psi = sign * bend
            q2 = atan2(z, r) - atan2(sign * span, k.a2 + lower_arm)
            q3 = psi - offset
            c23, s23 = cos(q2 + q3), sin(q2 + q3)
            wrist = _wrist(T, c1, s1, c23, s23)
            for flip in (0, 1):
                q, singular = wrist[flip]
                branch = [_wrap(v, lo, hi) for v, lo, hi in zip([q1, q2, q3, *q], k.lower, k.upper, strict=True)]
                joints += branch
                status.append(_status(branch, k, unreachable, singular))
    return joints, status


def _wrist(
    T: Vector, c1: Number, s1: Number, c23: Number, s23: Number
) -> tuple[tuple[list[Number], Condition | bool], tuple[list[Number], Condition | bool]]:
    """Both wrist solutions of R_36 = R_03^T R_06, q5 >= 0 first.

    Columns of R_03: (c1 c23, s1 c23, s23), (-s1, c1, 0), (-c1 s23, -s1 s23, c23).
    """
    ahead = [c1 * T[j] + s1 * T[4 + j] for j in range(3)]
    row1 = [c23 * ahead[j] + s23 * T[8 + j] for j in range(3)]
    row2 = [c1 * T[4 + j] - s1 * T[j] for j in range(3)]
    row3 = [c23 * T[8 + j] - s23 * ahead[j] for j in range(3)]
    sine = sqrt(row1[2] * row1[2] + row2[2] * row2[2])
    singular = less(sine, SINGULAR_SINE)
    q5 = atan2(sine, row3[2])
    q4 = select(singular, 0.0, atan2(-row2[2], -row1[2]))
    q6 = atan2(-row3[1], row3[0])
    # Wrist straight or folded: with q4 = 0, R_36 = Ry(-q5) Rz(q6), whose second row is (sin q6, cos q6, 0).
    alone = atan2(row2[0], row2[1])
    q6 = select(singular, alone, q6)
    q4_flip = select(singular, 0.0, atan2(row2[2], row1[2]))
    q6_flip = select(singular, alone, atan2(row3[1], -row3[0]))
    return ([q4, q5, q6], singular), ([q4_flip, -q5, q6_flip], singular)


def _wrap(q: Number, lower: float, upper: float) -> Number:
    """Bring an angle of less than two turns into (-pi, pi], then a turn towards its limits if it is outside."""
    q = select(less(math.pi, q), q - 2.0 * math.pi, q)
    q = select(less(q, -math.pi), q + 2.0 * math.pi, q)
    up, down = q + 2.0 * math.pi, q - 2.0 * math.pi
    if upper > math.pi:
        q = select(less(q, lower) & less(up, upper), up, q)
    if lower < -math.pi:
        q = select(less(upper, q) & less(lower, down), down, q)
    return q


def _status(q: Vector, k: PumaGeometry, unreachable: Condition | bool, singular: Condition | bool) -> Number:
    outside: Condition | bool = False
    for v, lo, hi in zip(q, k.lower, k.upper, strict=True):
        outside = outside | less(v, lo - LIMIT_TOLERANCE) | less(hi + LIMIT_TOLERANCE, v)
    status = select(singular, SINGULAR, OK)
    return select(unreachable, UNREACHABLE, select(outside, LIMIT, status))
