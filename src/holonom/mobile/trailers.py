"""A base that pulls trailers, by their kinematics alone: each has one axle, and a hitch on what goes before.

Trailer i with its axle L_i behind its hitch, which lies M_i behind the axle of the one before (0: on it; the base's is
base_link), follows (Laumond, Robot Motion Planning and Control, 1.3; Altafini 2001), with b = theta_(i-1) - theta_i,

    L_i w_i = v sin b - (M_i w - vy) cos b,      v_i = v cos b + (M_i w - vy) sin b

for v, vy, w of the one before; only the base may move sideways.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, vectors
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.poses import logarithm, relative
from holonom.trace.code.loops import loop

__all__ = ["Towed", "towed"]

FINE = 0.05
"""Part of the shortest trailer that a step moves at most, and radians that it turns."""


class Towed(NamedTuple):
    """Where trailers were.

    Attributes
    ----------
    poses : (N, n, 3) x, y (m) of the middle of each axle and heading (rad), in the world.
    angles : (N, n) by which what goes before each is turned against it, rad.
    jackknifed : the first pose at which one stands at right angles or more to what pulls it; None: none did.
    """

    poses: Array
    angles: Array
    jackknifed: int | None


def towed(
    poses: ArrayLike, lengths: ArrayLike, hitches: ArrayLike | None = None, *, headings: ArrayLike | None = None
) -> Towed:
    """Pull trailers along poses of a base.

    Parameters
    ----------
    poses : (N, 3) of base_link in the world, m and rad, near enough that arcs lie between them.
    lengths : (n,) from each trailer's hitch to its axle, m.
    hitches : (n,) how far each hitch lies behind the axle before it, m; below zero ahead of it. None: on the axles.
    headings : (n,) at the first pose, rad; None: all as the base.

    Returns
    -------
    Towed
        Nothing bumps or tips: a trailer that jackknifes is pulled on, and reported.

    Raises
    ------
    ShapeError
        Shapes that do not fit, fewer than two poses, no trailer, a number that is none.
    OutOfLimits
        A length that is not above zero.

    Notes
    -----
    Between two poses the base drives an arc; the headings follow by the classical Runge-Kutta method. Pulled forwards
    angles die out over their lengths, pushed backwards they grow. Trailers on the axles are flat: the path of the last
    axle tells all (Rouchon, Fliess, Levine, Martin 1993).
    """
    base = vectors("poses", poses, 3)
    L = finite("lengths", lengths)
    if base.ndim != 2 or len(base) < 2 or L.ndim != 1 or not len(L):
        raise ShapeError(f"poses have shape {base.shape}, lengths {L.shape}; give (N, 3) with N from 2, and (n,)")
    M = np.zeros(len(L)) if hitches is None else finite("hitches", hitches)
    start = np.full(len(L), base[0, 2]) if headings is None else finite("headings", headings)
    if M.shape != L.shape or start.shape != L.shape:
        raise ShapeError(f"{len(L)} lengths, hitches of shape {M.shape}, headings {start.shape}; give one of each")
    if L.min() <= 0.0:
        raise OutOfLimits(f"a trailer's length of {L.min():g} m came; give lengths above zero")
    steps = np.asarray(logarithm(relative(base[:-1], base[1:])))
    found = np.empty((len(base), len(L)))
    found[0] = start
    _pulled(np.ascontiguousarray(steps), L, M, float(base[0, 2]), found)
    heading = np.concatenate([[base[0, 2]], base[0, 2] + np.cumsum(steps[:, 2])])
    before = np.column_stack([heading, found[:, :-1]])
    angles = before - found
    places = np.empty((*found.shape, 2))
    at = base[:, :2]
    for i in range(len(L)):
        at = at - M[i] * _unit(before[:, i]) - L[i] * _unit(found[:, i])
        places[:, i] = at
    bent = np.flatnonzero((np.cos(angles) <= 0.0).any(axis=1))
    return Towed(np.concatenate([places, found[..., None]], axis=-1), angles, int(bent[0]) if len(bent) else None)


def _unit(heading: Array) -> Array:
    return np.stack([np.cos(heading), np.sin(heading)], axis=-1)


@loop(error_model="numpy")
def _pulled(steps: Array, L: Array, M: Array, heading: float, found: Array) -> None:
    """Headings (N, n) of trailers, of which the first row is given, along arcs (N - 1, 3) of the base."""
    n, least = len(L), L.min()
    now, slope, total, at = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for k in range(len(steps)):
        vx, vy, w = steps[k]
        way = math.sqrt(vx * vx + vy * vy) + abs(w) * abs(M[0])
        parts = int(max(way / least, abs(w)) / FINE) + 1
        h = 1.0 / parts
        now[:] = found[k]
        for _ in range(parts):
            total[:] = 0.0
            slope[:] = 0.0
            for stage in range(4):
                ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
                at[:] = now + ahead * slope
                _rates(vx, vy, w, heading + ahead * w, at, L, M, slope)
                total += slope * (2.0 if 0 < stage < 3 else 1.0)
            now += h / 6.0 * total
            heading += h * w
        found[k + 1] = now


@loop(error_model="numpy")
def _rates(vx: float, vy: float, w: float, heading: float, at: Array, L: Array, M: Array, slope: Array) -> None:
    """Turning rates (n,) of trailers at headings (n,)."""
    for i in range(len(L)):
        s, c = math.sin(heading - at[i]), math.cos(heading - at[i])
        aside = M[i] * w - vy
        slope[i] = (vx * s - aside * c) / L[i]
        vx, vy, w, heading = vx * c + aside * s, 0.0, slope[i], at[i]
