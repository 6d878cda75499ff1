"""Time-optimal path parametrisation by reachability analysis (Pham and Pham, IEEE Trans. Robotics 34, 2018).

Along the path x = (ds/dt)^2 and u = d2s/dt2; every limit is a row a u + b x <= c. The two variables of a stage are
few enough to eliminate u by pairing the rows (Fourier and Motzkin), so no linear program is solved.
"""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.trace.code.loops import loop

__all__ = ["controllable", "fastest"]


@loop(error_model="numpy")
def controllable(s: Array, a: Array, b: Array, c: Array, top: Array, lower: Array, upper: Array, rows: Array) -> int:
    """Squared speeds from which the path can be finished at rest, written to `lower` and `upper` (N,).

    Parameters
    ----------
    s
        Grid (N,).
    a, b, c
        Rows (N, m) of every grid point.
    top
        (N,) largest x that the speed limits allow.
    rows
        Scratch, (3, 2 m + 2).

    Returns
    -------
    -1, or the grid point at which no speed is left.
    """
    last = s.shape[0] - 1
    lower[last] = upper[last] = 0.0
    for i in range(last - 1, -1, -1):
        _stage(s, a, b, c, i, lower[i + 1], upper[i + 1], rows)
        low, high = 0.0, top[i]
        A, B, C = rows[0], rows[1], rows[2]
        for p in range(A.shape[0]):
            if A[p] == 0.0:
                low, high = _bound(B[p], C[p], low, high)
            elif A[p] > 0.0:
                for r in range(A.shape[0]):
                    if A[r] < 0.0:
                        low, high = _bound(A[p] * B[r] - A[r] * B[p], A[p] * C[r] - A[r] * C[p], low, high)
        if not low <= high:
            return i
        lower[i], upper[i] = low, high
    return -1


@loop(error_model="numpy")
def fastest(
    s: Array, a: Array, b: Array, c: Array, lower: Array, upper: Array, x: Array, u: Array, rows: Array
) -> None:
    """Greatest squared speeds `x` (N,) from rest that stay controllable, and the `u` (N - 1,) between them."""
    x[0] = 0.0
    for i in range(s.shape[0] - 1):
        _stage(s, a, b, c, i, lower[i + 1], upper[i + 1], rows)
        high, low = np.inf, -np.inf
        for p in range(rows.shape[1]):
            room = rows[2, p] - rows[1, p] * x[i]
            if rows[0, p] > 0.0:
                high = min(high, room / rows[0, p])
            elif rows[0, p] < 0.0:
                low = max(low, room / rows[0, p])
        step = 2.0 * (s[i + 1] - s[i])
        x[i + 1] = min(max(x[i] + step * max(high, low), lower[i + 1]), upper[i + 1])
        u[i] = (x[i + 1] - x[i]) / step


@loop(error_model="numpy")
def _bound(coefficient: float, right: float, low: float, high: float) -> tuple[float, float]:
    """`low` <= x <= `high` and coefficient x <= right."""
    if coefficient > 0.0:
        return low, min(high, right / coefficient)
    if coefficient < 0.0:
        return max(low, right / coefficient), high
    return low, high if right >= 0.0 else -np.inf


@loop(error_model="numpy")
def _stage(s: Array, a: Array, b: Array, c: Array, i: int, low: float, high: float, rows: Array) -> None:
    """All rows of the interval from i to i + 1: the limits at both its ends, and what is controllable at the next."""
    m, step = a.shape[1], 2.0 * (s[i + 1] - s[i])
    for k in range(m):
        rows[0, k], rows[1, k], rows[2, k] = a[i, k], b[i, k], c[i, k]
        rows[0, m + k], rows[1, m + k], rows[2, m + k] = a[i + 1, k] + step * b[i + 1, k], b[i + 1, k], c[i + 1, k]
    rows[0, 2 * m], rows[1, 2 * m], rows[2, 2 * m] = step, 1.0, high
    rows[0, 2 * m + 1], rows[1, 2 * m + 1], rows[2, 2 * m + 1] = -step, -1.0, -low
