"""Singular values and vectors of small matrices in compiled code, by one-sided Jacobi rotations (Hestenes 1958).

A Jacobian of six rows takes 3 to 4 us, a quarter of what LAPACK's call takes from Python, and small singular values are
at least as accurate (Demmel & Veselic 1992).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, njit
from numpy.typing import NDArray

from holonom.trace.direct import ArrayObject, array_of, direct, fits
from holonom.trace.results import Results, entry, exists, made_like, nothing

__all__ = ["decompose", "svd_of_one", "svd_of_rows", "values_of_one", "values_of_rows"]

Floats = NDArray[np.float64]
ROUNDING = 1e-15
"""Cosine between two rows up to which they count as orthogonal."""
SWEEPS = 30
"""Sweeps over all pairs after which rows stay as they are; five do, and NaN never ends."""
TINY = 1e-70
"""Length of a row, as a share of the largest entry, that counts as 0: between two shorter ones `_orthogonalise` sees
no angle, for fourth powers are no numbers any more."""


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _orthogonalise(Y: Floats, R: Floats) -> None:
    """Turn pairs of the first rows of Y until all are orthogonal, and the rows of R (k, ...) alike (Hestenes 1958)."""
    for _ in range(SWEEPS):
        still = True
        for i in range(R.shape[0] - 1):
            for j in range(i + 1, R.shape[0]):
                a = b = d = 0.0
                for k in range(Y.shape[1]):
                    a, b, d = a + Y[i, k] * Y[i, k], b + Y[j, k] * Y[j, k], d + Y[i, k] * Y[j, k]
                if d * d <= ROUNDING * ROUNDING * a * b:
                    continue
                still = False
                cotangent = (b - a) / (2.0 * d)  # of twice the angle
                t = math.copysign(1.0, cotangent) / (abs(cotangent) + math.sqrt(1.0 + cotangent * cotangent))
                c = 1.0 / math.sqrt(1.0 + t * t)
                for k in range(Y.shape[1]):
                    Y[i, k], Y[j, k] = c * (Y[i, k] - t * Y[j, k]), c * (t * Y[i, k] + Y[j, k])
                for k in range(R.shape[1]):
                    R[i, k], R[j, k] = c * (R[i, k] - t * R[j, k]), c * (t * R[i, k] + R[j, k])
        if still:
            return


@njit(cache=True, error_model="numpy")
def decompose(A: Floats, Y: Floats, R: Floats, s: Floats) -> int:
    """Write A (m, n), or its transpose if m > n, as R^T diag(s) Y: rows of Y orthonormal, s (k,) largest first.

    R is (k, k), or (k, 0) where it is not asked for; of Y the first k rows are written, k = min(m, n). Returns how many
    of them there are: the other singular values are zero, their rows too.
    """
    m, n = A.shape
    size = 0.0
    for x in A.flat:
        size = max(size, abs(x))
    unit = size if size > 0.0 else 1.0
    for i in range(s.shape[0]):
        for j in range(Y.shape[1]):
            Y[i, j] = (A[i, j] if m <= n else A[j, i]) / unit
        for j in range(R.shape[1]):
            R[i, j] = 1.0 if i == j else 0.0
    _orthogonalise(Y, R)
    for i in range(s.shape[0]):
        square = 0.0
        for j in range(Y.shape[1]):
            square += Y[i, j] * Y[i, j]
        s[i] = math.sqrt(square)
    rank = 0
    for i in range(s.shape[0]):
        largest = i
        for j in range(i + 1, s.shape[0]):
            if s[j] > s[largest]:
                largest = j
        s[i], s[largest] = s[largest], s[i]
        for j in range(R.shape[1]):
            R[i, j], R[largest, j] = R[largest, j], R[i, j]
        for j in range(Y.shape[1]):
            Y[i, j], Y[largest, j] = Y[largest, j], Y[i, j]
        if s[i] > TINY:
            rank += 1
            for j in range(Y.shape[1]):
                Y[i, j] /= s[i]
        s[i] *= unit
    return rank


@njit(cache=True, error_model="numpy")
def _complete(Y: Floats, count: int) -> None:
    """Make the rows of a square matrix after the first ones orthonormal too: Gram-Schmidt, twice, of axes."""
    n = Y.shape[0]
    for row in range(count, n):
        axis, least = 0, np.inf
        for k in range(n):
            covered = 0.0
            for i in range(row):
                covered += Y[i, k] * Y[i, k]
            if covered < least:
                axis, least = k, covered
        for k in range(n):
            Y[row, k] = 1.0 if k == axis else 0.0
        for again in range(2 * row):
            i, along = again % row, 0.0
            for k in range(n):
                along += Y[i, k] * Y[row, k]
            for k in range(n):
                Y[row, k] -= along * Y[i, k]
        square = 0.0
        for k in range(n):
            square += Y[row, k] * Y[row, k]
        for k in range(n):
            Y[row, k] /= math.sqrt(square)


@njit(cache=True, error_model="numpy")
def _svd(A: Floats, U: Floats, s: Floats, Vt: Floats) -> None:
    """A = U[:, :k] diag(s) Vt[:k], with U (m, m) and Vt (n, n) orthogonal."""
    Y, R = (Vt, U) if A.shape[0] <= A.shape[1] else (U, Vt)
    _complete(Y, decompose(A, Y, R, s))
    for i in range(U.shape[0]):
        for j in range(i):
            U[i, j], U[j, i] = U[j, i], U[i, j]


@njit(cache=True, error_model="numpy")
def _values(A: Floats, s: Floats) -> None:
    k = s.shape[0]
    decompose(A, np.empty((k, max(A.shape))), np.empty((k, 0)), s)


@njit(cache=True, nogil=True, error_model="numpy")
def svd_of_rows(A: Floats, U: Floats, s: Floats, Vt: Floats) -> None:
    """`svd` of each A (N, m, n): U (N, m, m), s (N, k), Vt (N, n, n)."""
    for row in range(A.shape[0]):
        _svd(A[row], U[row], s[row], Vt[row])


@njit(cache=True, nogil=True, error_model="numpy")
def values_of_rows(A: Floats, s: Floats) -> None:
    """Singular values s (N, k) of each A (N, m, n)."""
    for row in range(A.shape[0]):
        _values(A[row], s[row])


_LIST, _TABLE = ArrayObject(float64, (None,)), ArrayObject(float64, (None, None))
_THREE = Results([_TABLE, _LIST, _TABLE])


@njit(_THREE(_TABLE, _THREE), cache=True, error_model="numpy")
def _svd_of_one(A: Any, like: Any) -> Any:
    if not fits(A):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        _svd(array_of(A), array_of(entry(result, 0)), array_of(entry(result, 1)), array_of(entry(result, 2)))
    return result


@njit(_LIST(_TABLE, _LIST), cache=True, error_model="numpy")
def _values_of_one(A: Any, like: Any) -> Any:
    if not fits(A):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        _values(array_of(A), array_of(result))
    return result


svd_of_one: Any = direct(_svd_of_one)
"""`svd_of_one(A, like)`: U, s and Vt of one matrix, in a tuple like the one given; None if A is no C-ordered matrix."""
values_of_one: Any = direct(_values_of_one)
"""`values_of_one(A, like)`: the singular values of one matrix, in an array like the one given; or None."""
