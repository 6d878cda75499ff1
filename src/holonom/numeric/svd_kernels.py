"""Singular values and vectors of small matrices in compiled code, by one-sided Jacobi rotations.

A Jacobian of six rows takes 1 us, a fifteenth of what LAPACK's call takes from Python, and small singular values are at
least as accurate (Demmel & Veselic 1992).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.numeric.jacobi_kernels import (
    COLUMN,
    FACTOR,
    ORDER,
    RANK,
    RESULTS,
    SQUARE,
    TINY,
    WEIGHT,
    laid_out,
    orthogonalise,
    ranked,
    slot,
)
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import load

__all__ = [
    "ROOM",
    "complete",
    "decompose",
    "room_for",
    "rows_of_turns",
    "svd_of_rows",
    "unit_rows",
    "values_of_rows",
    "weights",
]

ROOM = 512
"""Numbers on the stack for one configuration."""


@loop(error_model="numpy")
def room_for(m: int, n: int) -> int:
    """How many numbers the decomposition of a matrix (m, n) needs room for."""
    return COLUMN * (m + n + RESULTS)


@loop(error_model="numpy")
def decompose(A: Array, room: Array, s: Array, turns: bool) -> int:
    """Factorise A (m, n), or its transpose if m > n, as R^T diag(s) Y, with s (k,), k = min(m, n), largest first.

    R (k, k) is orthogonal, the first rows of Y (k, n) are orthonormal. Returns how many of these there are: the other
    singular values are zero, their rows too. They stay in room, for `rows_of_turns` if R was asked for and `unit_rows`.
    """
    k, columns = s.shape[0], max(A.shape)
    more = k if turns else 0
    unit = laid_out(A, room, more)
    for i in range(more):
        room[COLUMN * (columns + i) + slot(i, k)] = 1.0
    orthogonalise(room, k, columns, more)
    results = columns + more
    ranked(room, results)
    for i in range(k):
        s[i] = -1.0
    rank = 0
    for at in range(COLUMN):
        i = int(room[COLUMN * (results + RANK) + at])
        while i < k and not s[i] < 0.0:  # equal ones: the next place
            i += 1
        if i < k:
            length = math.sqrt(room[COLUMN * (results + SQUARE) + at])
            s[i] = length * unit
            room[COLUMN * (results + ORDER) + i] = at
            rank += length > TINY
    return rank


@loop(error_model="numpy")
def rows_of_turns(room: Array, columns: int, k: int, first: int, R: Array) -> None:
    """Write rows of R from a first one on."""
    results = columns + k
    for i in range(first, k):
        at = int(room[COLUMN * (results + ORDER) + i])
        factor = room[COLUMN * (results + FACTOR) + at]
        for j in range(k):
            R[i - first, j] = factor * room[COLUMN * (columns + j) + at]


@loop(error_model="numpy")
def unit_rows(room: Array, columns: int, more: int, count: int, Y: Array) -> None:
    """Write the first rows of Y; more: k if R was asked for, else 0."""
    results = columns + more
    for i in range(count):
        at = int(room[COLUMN * (results + ORDER) + i])
        scale = room[COLUMN * (results + FACTOR) + at] / math.sqrt(room[COLUMN * (results + SQUARE) + at])
        for j in range(columns):
            Y[i, j] = scale * room[COLUMN * j + at]


@loop(error_model="numpy")
def weights(room: Array, columns: int, count: int) -> Any:
    """Of each row in room 1 / |row|^2, and 0 of all but the first `count` in order; R was not asked for."""
    for at in range(COLUMN):
        room[COLUMN * (columns + WEIGHT) + at] = 0.0
    for i in range(count):
        at = int(room[COLUMN * (columns + ORDER) + i])
        factor = room[COLUMN * (columns + FACTOR) + at]
        room[COLUMN * (columns + WEIGHT) + at] = factor * factor / room[COLUMN * (columns + SQUARE) + at]
    at = 2 * (columns + WEIGHT)
    return load(room, at), load(room, at + 1)


@loop(error_model="numpy")
def complete(Y: Array, count: int) -> None:
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


@loop(error_model="numpy")
def _svd(A: Array, room: Array, U: Array, s: Array, Vt: Array) -> None:
    """A = U[:, :k] diag(s) Vt[:k], with U (m, m) and Vt (n, n) orthogonal."""
    k, columns = s.shape[0], max(A.shape)
    Y, R = (Vt, U) if A.shape[0] <= A.shape[1] else (U, Vt)
    rank = decompose(A, room, s, True)
    rows_of_turns(room, columns, k, 0, R)
    unit_rows(room, columns, k, rank, Y)
    complete(Y, rank)
    for i in range(U.shape[0]):
        for j in range(i):
            U[i, j], U[j, i] = U[j, i], U[i, j]


@loop(nogil=True, error_model="numpy")
def svd_of_rows(A: Array, U: Array, s: Array, Vt: Array) -> None:
    """`svd` of each A (N, m, n): U (N, m, m), s (N, k), Vt (N, n, n)."""
    room = np.empty(room_for(*A.shape[1:]))
    for row in range(A.shape[0]):
        _svd(A[row], room, U[row], s[row], Vt[row])


@loop(nogil=True, error_model="numpy")
def values_of_rows(A: Array, s: Array) -> None:
    """Singular values s (N, k) of each A (N, m, n)."""
    room = np.empty(room_for(*A.shape[1:]))
    for row in range(A.shape[0]):
        decompose(A[row], room, s[row], False)
