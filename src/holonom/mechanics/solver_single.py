"""The search of the numerical inverse for one pose: what one call from Python costs beside the search is this way in.

A module of its own: it compiles the search once more, for those who ask for one pose at a time.
"""

from __future__ import annotations

import math

import numpy as np
from numba import boolean, float64, int64, njit
from numpy.typing import NDArray

from holonom.mechanics.pose_check import is_rigid
from holonom.mechanics.solver_kernels import Chain, Search, scratch, solve, status_of

__all__ = ["solve_one"]

Floats = NDArray[np.float64]


@njit(
    int64(float64[:, ::1], float64[::1], int64[::1], boolean, float64[:, ::1], float64[::1], float64[::1],
          float64[::1], float64[::1]),
    cache=True,
    error_model="numpy",
)  # fmt: skip
def solve_one(
    limits: Floats,
    numbers: Floats,
    whole: NDArray[np.int64],
    bounded: bool,
    T: Floats,
    start: Floats,
    preferred: Floats,
    q: Floats,
    residual: Floats,
) -> int:
    """Solve for one pose T (4, 4), from `start`: (n,), or (0,) for none, as `preferred`.

    The fields of `Chain` come as the rows of `limits`, those of `Search` as `whole` and `numbers` (tolerance, then
    weights), for arrays go through faster than records. q (n,) and residual (1,) are written.

    Returns
    -------
    Four times the steps plus the status; -1 if T is no pose, or the start not finite or, if `bounded`, not in the
    limits.
    """
    n = limits.shape[1]
    if start.shape[0] not in (0, n) or preferred.shape[0] not in (0, n) or not is_rigid(T):
        return -1
    for x in preferred:
        if not abs(x) < np.inf:
            return -1
    for k in range(start.shape[0]):
        if not abs(start[k]) < np.inf:
            return -1
        if bounded and not limits[0, k] - 1e-9 <= start[k] <= limits[1, k] + 1e-9:
            return -1
    chain = Chain(limits[0], limits[1], limits[2], limits[3], limits[4], limits[5])
    search = Search(whole[0], whole[1], whole[2], numbers[1:], numbers[0], whole[3], whole[4], whole[5])
    room = scratch(n)
    for i in range(3):
        room.source[n + 4 * i : n + 4 * i + 4] = T[i]
    room.source[n + 12 :] = search.weights
    least, total, blocked = solve(chain, search, room, start, preferred, 0)
    q[:] = room.best
    residual[0] = math.sqrt(least)
    return 4 * total + status_of(search, least, blocked)
