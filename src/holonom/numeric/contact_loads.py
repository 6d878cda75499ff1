"""Loads of contacts that only push: a rigid body on equal springs under its contacts, none of which can pull.

Loads are `max(0, a + b x + c y)`, so that the energy of the springs is least among all loads that carry weight and
moments (a linear complementarity problem; Cottle, Pang & Stone, The Linear Complementarity Problem, 1.2). The plane
(a, b, c) is the minimum of a convex, piecewise quadratic function: Newton with halved steps finds it in a few.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.numeric.small_kernels import solve_positive3
from holonom.trace.code.loops import loop

__all__ = ["pushing_loads", "pushing_loads_at"]

STEPS = 60
SOFT = 1e-10  # added to the normal matrix, over its usual size: contacts that carry may lie on one line
BALANCED = 1e-13  # part of the weight by which force and moments (over the contacts' reach) may be missed
ROUNDING = 1e-8  # the same where no better is found: the force passes through an edge of the hull


def pushing_loads(points: Array, moments: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Loads (..., n) of contacts at points (n, 2) that carry 1 through (..., 2), and whether the body stands (...).

    Where the force passes outside the hull of the contacts the body tips: the loads of those rows are 0.
    """
    middle = points.mean(axis=0)
    at = np.ascontiguousarray(points - middle)
    balance = np.concatenate([np.ones((1, len(at))), at.T])
    asked = np.concatenate([np.ones((*moments.shape[:-1], 1)), moments - middle], axis=-1)
    loads = np.ascontiguousarray(asked @ np.linalg.pinv(balance).T)
    flat, rows = loads.reshape(-1, len(at)), asked.reshape(-1, 3)
    stands = np.ones(len(flat), dtype=np.bool_)
    for k in np.flatnonzero(flat.min(axis=1) < 0.0):
        stands[k] = pushing_loads_at(at, 1.0, rows[k, 1], rows[k, 2], flat[k])
        if not stands[k]:
            flat[k] = 0.0
    return flat.reshape(loads.shape), stands.reshape(loads.shape[:-1])


@loop(error_model="numpy")
def pushing_loads_at(points: Array, weight: float, mx: float, my: float, loads: Array) -> bool:
    """Fill `loads` (n,) of contacts at points (n, 2) so that they carry a weight and its moments; False: it tips.

    `mx` and `my` are the sums of load times x and of load times y.
    """
    n, reach = points.shape[0], 1e-12
    for i in range(n):
        reach = max(reach, math.hypot(points[i, 0], points[i, 1]))
    u, v = mx / (weight * reach), my / (weight * reach)
    a = b = c = 0.0
    low = missed = math.inf
    da, db, dc = 1.0 / n, 0.0, 0.0
    for _ in range(STEPS):
        part = 1.0
        ta, tb, tc, energy = a, b, c, low
        for _ in range(40):  # halve the step until it leads down
            ta, tb, tc = a + part * da, b + part * db, c + part * dc
            energy = -ta - tb * u - tc * v
            for i in range(n):
                load = max(ta + (tb * points[i, 0] + tc * points[i, 1]) / reach, 0.0)
                energy += 0.5 * load * load
            if energy < low:
                break
            part *= 0.5
        if not energy < low:
            break
        a, b, c, low = ta, tb, tc, energy
        oo = xx = yy = SOFT
        ox = oy = xy = 0.0
        ra, rb, rc = 1.0, u, v
        for i in range(n):
            x, y = points[i, 0] / reach, points[i, 1] / reach
            load = max(a + b * x + c * y, 0.0)
            loads[i] = weight * load
            ra, rb, rc = ra - load, rb - load * x, rc - load * y
            if load > 0.0:
                oo, xx, yy, ox, oy, xy = oo + 1.0, xx + x * x, yy + y * y, ox + x, oy + y, xy + x * y
        missed = max(abs(ra), abs(rb), abs(rc))
        if missed <= BALANCED:
            break
        da, db, dc = solve_positive3(oo, xx, yy, ox, oy, xy, ra, rb, rc)
    if not missed <= ROUNDING:
        return False
    carried = 0.0
    for i in range(n):
        carried += loads[i]
    for i in range(n):
        loads[i] *= weight / carried
    return True
