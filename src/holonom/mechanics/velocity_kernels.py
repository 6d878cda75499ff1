"""Joint rates for a twist by the singular values of the Jacobian, in compiled code."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, njit
from numpy.typing import NDArray

from holonom.mechanics.svd_kernels import decompose
from holonom.trace.direct import ArrayObject, array_of, direct, fits
from holonom.trace.results import exists, made_like, nothing

__all__ = ["AUTO", "rates_of_one", "rates_of_rows"]

Floats = NDArray[np.float64]
AUTO = -1.0
"""Damping that follows the smallest singular value."""
NEAR = 0.02
"""Smallest singular value, as a share of the largest one, below which automatic damping sets in."""
LOST = 1e-12
"""Singular value, as a share of the largest one, below which a direction is lost altogether."""


@njit(cache=True, error_model="numpy")
def _rates(J: Floats, twist: Floats, damping: float, qd: Floats) -> None:
    """Sum of s / (s^2 + lambda^2) v u^T twist over the singular values s of J (6, n).

    lambda = `damping`, or if it is `AUTO` as `velocity.joint_rates` says.
    """
    m, n = J.shape
    k = min(m, n)
    Y, R, s = np.empty((k, max(m, n))), np.empty((k, k)), np.empty(k)
    decompose(J, Y, R, s)
    u, v = (R, Y) if m <= n else (Y, R)
    square = damping * damping if damping != AUTO else max((NEAR * s[0]) ** 2 - s[k - 1] ** 2, 0.0)
    qd[:] = 0.0
    for i in range(k):
        if s[i] > LOST * s[0]:
            along = 0.0
            for j in range(m):
                along += u[i, j] * twist[j]
            qd += s[i] / (s[i] * s[i] + square) * along * v[i]


@njit(cache=True, nogil=True, error_model="numpy")
def rates_of_rows(J: Floats, twist: Floats, damping: float, qd: Floats) -> None:
    """The rates of rows: J (N, 6, n), twist (N, 6), qd (N, n)."""
    for row in range(J.shape[0]):
        _rates(J[row], twist[row], damping, qd[row])


_LIST, _TABLE = ArrayObject(float64, (None,)), ArrayObject(float64, (None, None))


@njit(_LIST(_TABLE, _LIST, float64, _LIST), cache=True, error_model="numpy")
def _rates_of_one(J: Any, twist: Any, damping: float, like: Any) -> Any:
    if not (fits(J) and fits(twist)):
        return nothing(like)
    wanted = array_of(twist)
    if wanted.shape[0] != array_of(J).shape[0] or not np.isfinite(wanted.sum()):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        _rates(array_of(J), wanted, damping, array_of(result))
    return result


rates_of_one: Any = direct(_rates_of_one)
"""`rates_of_one(J, twist, damping, like)`: qd of one sample, in an array like the one given; None also for NaN."""
