"""Singular values and vectors of small matrices in compiled code, by one-sided Jacobi rotations.

A Jacobian of six rows takes 1 us, a fifteenth of what LAPACK's call takes from Python, and small singular values are at
least as accurate (Demmel & Veselic 1992).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import float64, njit
from numpy.typing import NDArray

from holonom.mechanics.jacobi_kernels import COLUMN, SPARE, TINY, laid_out, orthogonalise, ranked, slot
from holonom.trace.direct import ArrayObject, array_of, direct, fits, scratch
from holonom.trace.results import Results, entry, exists, made_like, nothing

__all__ = ["ROOM", "complete", "decompose", "room_for", "svd_of_one", "svd_of_rows", "values_of_one", "values_of_rows"]

Floats = NDArray[np.float64]
ROOM = 512
"""Numbers on the stack for one matrix; a longer one than `room_for` allows goes the way of rows."""


@njit(cache=True, error_model="numpy")
def room_for(m: int, n: int) -> int:
    """How many numbers the decomposition of a matrix (m, n) needs room for."""
    return COLUMN * (m + n + SPARE)


@njit(cache=True, error_model="numpy")
def decompose(A: Floats, room: Floats, R: Floats, s: Floats, Y: Floats) -> int:
    """Write A (m, n), or its transpose if m > n, as R^T diag(s) Y: rows of Y orthonormal, s (k,) largest first.

    R is (k, k) or, where it is not asked for, (0, k); of Y the first k rows are written, k = min(m, n), or none if it
    has none. Returns how many of them there are: the other singular values are zero, their rows too.
    """
    k, columns = s.shape[0], max(A.shape)
    more = R.shape[0]
    unit = laid_out(A, room, more)
    for i in range(more):
        room[COLUMN * (columns + i) + slot(i, k)] = 1.0
    orthogonalise(room, k, columns, more)
    end = columns + more
    ranked(room, end + 1)
    rank = 0
    for i in range(k):
        s[i] = -1.0
    for at in range(COLUMN):
        i = int(room[COLUMN * (end + 2) + at])
        while i < k and not s[i] < 0.0:  # equal ones: the next place
            i += 1
        if i < k:
            factor, length = room[COLUMN * end + at], math.sqrt(room[COLUMN * (end + 1) + at])
            s[i] = length * unit
            for j in range(more):
                R[i, j] = factor * room[COLUMN * (columns + j) + at]
            if length > TINY:
                rank += 1
            if Y.shape[0] > 0:
                for j in range(columns):
                    Y[i, j] = factor / length * room[COLUMN * j + at]
    return rank


@njit(cache=True, error_model="numpy")
def complete(Y: Floats, count: int) -> None:
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
        for i in range(row):
            along = Y[i, axis]
            for k in range(n):
                Y[row, k] -= along * Y[i, k]
        for i in range(row):
            along = 0.0
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
def _svd(A: Floats, room: Floats, U: Floats, s: Floats, Vt: Floats) -> None:
    """A = U[:, :k] diag(s) Vt[:k], with U (m, m) and Vt (n, n) orthogonal."""
    Y, R = (Vt, U) if A.shape[0] <= A.shape[1] else (U, Vt)
    complete(Y, decompose(A, room, R, s, Y))
    for i in range(U.shape[0]):
        for j in range(i):
            U[i, j], U[j, i] = U[j, i], U[i, j]


@njit(cache=True, nogil=True, error_model="numpy")
def svd_of_rows(A: Floats, U: Floats, s: Floats, Vt: Floats) -> None:
    """`svd` of each A (N, m, n): U (N, m, m), s (N, k), Vt (N, n, n)."""
    room = np.empty(room_for(*A.shape[1:]))
    for row in range(A.shape[0]):
        _svd(A[row], room, U[row], s[row], Vt[row])


@njit(cache=True, nogil=True, error_model="numpy")
def values_of_rows(A: Floats, s: Floats) -> None:
    """Singular values s (N, k) of each A (N, m, n)."""
    room = np.empty(room_for(*A.shape[1:]))
    nothing_else = room[:0].reshape(0, 1)
    for row in range(A.shape[0]):
        decompose(A[row], room, nothing_else, s[row], nothing_else)


_LIST, _TABLE = ArrayObject(float64, (None,)), ArrayObject(float64, (None, None))
_THREE = Results([_TABLE, _LIST, _TABLE])


@njit(_THREE(_TABLE, _THREE), cache=True, error_model="numpy")
def _svd_of_one(A: Any, like: Any) -> Any:
    if not fits(A) or room_for(*array_of(A).shape) > ROOM:
        return nothing(like)
    result = made_like(like)
    if exists(result):
        room = scratch(ROOM)
        _svd(array_of(A), room, array_of(entry(result, 0)), array_of(entry(result, 1)), array_of(entry(result, 2)))
    return result


@njit(_LIST(_TABLE, _LIST), cache=True, error_model="numpy")
def _values_of_one(A: Any, like: Any) -> Any:
    if not fits(A) or room_for(*array_of(A).shape) > ROOM:
        return nothing(like)
    result = made_like(like)
    if exists(result):
        room = scratch(ROOM)
        nothing_else = room[:0].reshape(0, 1)
        decompose(array_of(A), room, nothing_else, array_of(result), nothing_else)
    return result


svd_of_one: Any = direct(_svd_of_one)
"""`svd_of_one(A, like)`: U, s and Vt of one matrix, in a tuple like the one given; None if A is no C-ordered matrix."""
values_of_one: Any = direct(_values_of_one)
"""`values_of_one(A, like)`: the singular values of one matrix, in an array like the one given; or None."""
