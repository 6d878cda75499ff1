"""Rows of a small matrix turned until they are orthogonal: one-sided Jacobi rotations, three pairs of rows at a time.

A rotation that makes two rows orthogonal (Hestenes 1958) is a long chain: scalar products, a root, quotients. Six rows
are three pairs that do not meet, so three rotations run side by side as lanes of a pack (`trace.simd`); after five such
rounds each row has met each other one (a round robin, as Brent & Luk 1985). A row is kept as x with a factor d^1/2
apart, so that a rotation is `x - t y`, `y + u x` without its cosine, which d alone takes in (Gentleman's fast
rotations; Anda & Park 1994).

A matrix lies in its room column by column, `COLUMN` numbers each: a pack of the pairs' first rows, then one of their
second ones. After the columns to be made orthogonal come any that are to be turned alike, then those of results.
"""

from __future__ import annotations

import math
from typing import Any

from holonom.arrays import Array
from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import any_of, chosen, largest, load, spread, store

__all__ = [
    "COLUMN",
    "FACTOR",
    "MOST",
    "ORDER",
    "RANK",
    "RESULTS",
    "SQUARE",
    "TINY",
    "WEIGHT",
    "laid_out",
    "orthogonalise",
    "ranked",
    "slot",
]

MOST, COLUMN = 6, 8
"""Rows at most; numbers that a column takes."""
FACTOR, SQUARE, RANK, ORDER, WEIGHT, RESULTS = range(6)
"""Columns of results, after the others: factors of the rows, squares of their lengths (-1 where there is no row), how
many are longer, and what `svd_kernels` notes; how many such columns there are."""
ROUNDING = 1e-15
"""Cosine between two rows up to which they count as orthogonal."""
QUIET = 1e-8
"""Root of the rounding: once all cosines and angles of a sweep are smaller, rows are orthogonal.

For what a rotation undoes of one before is no more than the product of two of them. Angles count by themselves: those
of two rows of nearly the same length may be large, however small their cosine is.
"""
SWEEPS = 30
"""Sweeps over all pairs after which rows stay as they are; five do."""
TINY = 1e-70
"""Length of a row, as a share of the largest entry, that counts as 0: between two shorter ones no angle is seen, for
fourth powers are no numbers any more."""
SMALL, LARGE = 1e-5, 1e5
"""Between these the largest entry is as good as 1."""


_SIX, _FOUR = (0, 4, 2, 5, 1, 6), (0, 1, 4, 5)


@loop(error_model="numpy")
def slot(row: int, rows: int) -> int:
    """Where a row stands in a column: first ones of the pairs in lanes 0, 1, 2 of one pack, second ones in the next.

    Of six, as rows of a Jacobian get orthogonal a round sooner than in their own order.
    """
    if rows > 4:
        return _SIX[row]
    return _FOUR[row] if rows > 2 else 4 * row


@loop(error_model="numpy")
def laid_out(A: Array, room: Array, more: int) -> float:
    """Write A (m, n), or its transpose if m > n, column by column to room, and clear as many more columns after it.

    The factors are set to 1, or 0 where there is no row. Returns the unit of the numbers in room: 1, unless those of A
    are very large or very small.
    """
    m, n = A.shape
    rows, columns = min(m, n), max(m, n)
    factors = COLUMN * (columns + more)
    room[: factors + COLUMN] = 0.0
    for i in range(rows):
        at = slot(i, rows)
        room[factors + at] = 1.0
        if m <= n:
            for k in range(columns):
                room[COLUMN * k + at] = A[i, k]
        else:
            for k in range(columns):
                room[COLUMN * k + at] = A[k, i]
    first, second = spread(0.0), spread(0.0)
    for k in range(columns):
        first, second = max(first, abs(load(room, 2 * k))), max(second, abs(load(room, 2 * k + 1)))
    size = largest(max(first, second))
    if SMALL <= size <= LARGE or size == 0.0:
        return 1.0
    for k in range(COLUMN * columns):
        room[k] /= size
    return size


@loop(error_model="numpy")
def _next_first(x: Any, y: Any, pairs: int) -> Any:
    """The first rows of the pairs that meet next: row 0 stays, the others go round."""
    if pairs == 3:
        return chosen(x, y, 0, 6, 5, 3)
    if pairs == 2:
        return chosen(x, y, 0, 5, 2, 3)
    return x


@loop(error_model="numpy")
def _next_second(x: Any, y: Any, pairs: int) -> Any:
    """Their second rows."""
    return chosen(x, y, 1, 4, 2, 7) if pairs > 1 else y


@loop(error_model="numpy", fastmath={"contract"})
def orthogonalise(room: Array, rows: int, columns: int, more: int) -> None:
    """Rotate pairs of rows until all are orthogonal over the first columns, and the columns after these alike.

    Rows change places; their factors and the squares of their lengths, factors included, are written.
    """
    pairs, end = (rows + 1) // 2, 2 * (columns + more)
    x, y = load(room, 0), load(room, 1)
    a, b, d = x * x, y * y, x * y
    for k in range(1, columns):
        x, y = load(room, 2 * k), load(room, 2 * k + 1)
        a, b, d = a + x * x, b + y * y, d + x * y
    zero, p, q = spread(0.0), load(room, end), load(room, end + 1)  # p, q: squares of the factors
    quiet = 0
    for _ in range(SWEEPS * (2 * pairs - 1)):
        a, b, square = p * a, q * b, p * q * (d * d)
        both = a * b
        turning = square > ROUNDING * ROUNDING * both
        # tan of the angle by cot of the double angle, (b - a) / (2 d), the factors multiplied in
        twice = math.copysign(select(turning, d + d, zero), (b - a) * d)
        inverse = 1.0 / (math.sqrt((b - a) * (b - a) + 4.0 * square) + (abs(b - a) + 1e-300))
        t, u = q * twice * inverse, p * twice * inverse
        loud = any_of(turning & ((square > QUIET * QUIET * both) | (t * u > QUIET * QUIET)))
        cosine = 1.0 / (1.0 + t * u)  # its square
        p, q = p * cosine, q * cosine
        p, q = _next_first(p, q, pairs), _next_second(p, q, pairs)
        a = b = d = zero
        for k in range(columns):
            x, y = load(room, 2 * k), load(room, 2 * k + 1)
            x, y = x - t * y, y + u * x
            x, y = _next_first(x, y, pairs), _next_second(x, y, pairs)
            store(room, 2 * k, x)
            store(room, 2 * k + 1, y)
            a, b, d = a + x * x, b + y * y, d + x * y
        for k in range(columns, columns + more):
            x, y = load(room, 2 * k), load(room, 2 * k + 1)
            x, y = x - t * y, y + u * x
            store(room, 2 * k, _next_first(x, y, pairs))
            store(room, 2 * k + 1, _next_second(x, y, pairs))
        quiet = 0 if loud else quiet + 1
        if quiet == 2 * pairs - 1:
            break
    store(room, end, math.sqrt(p))
    store(room, end + 1, math.sqrt(q))
    store(room, end + 2, select(p > zero, p * a, spread(-1.0)))
    store(room, end + 3, select(q > zero, q * b, spread(-1.0)))


@loop(error_model="numpy")
def ranked(room: Array, results: int) -> None:
    """Write of each row how many are longer; results: the first column of results."""
    at = 2 * (results + SQUARE)
    x, y = load(room, at), load(room, at + 1)
    zero, one, first, second = spread(0.0), spread(1.0), spread(0.0), spread(0.0)
    for k in range(COLUMN):
        number = spread(room[COLUMN * (results + SQUARE) + k])
        first += select(number > x, one, zero)
        second += select(number > y, one, zero)
    store(room, 2 * (results + RANK), first)
    store(room, 2 * (results + RANK) + 1, second)
