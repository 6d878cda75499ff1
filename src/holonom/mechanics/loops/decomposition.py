"""The decompositions of `mechanics.analysis` at one configuration: from q to the result in one compiled call.

Each is compiled when it is first asked for, by a call without arguments. It takes a plan (`plan_of`), and results to
take after, and returns None if q is no such array of finite numbers; the general way then says what is wrong with it.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import boolean, float64, int64
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.mechanics.kernels.singularities import rows_of
from holonom.numeric.svd_kernels import ROOM, complete, decompose, room_for, rows_of_turns, unit_rows, weights
from holonom.trace.call.direct import ArrayObject, array_of, direct, fits, scratch
from holonom.trace.call.pointer import call_kernel
from holonom.trace.call.results import Results, entry, exists, made_like, nothing, put, release
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import load, spread, total

__all__ = [
    "LOST",
    "PLAN",
    "Prepared",
    "asked_for",
    "ellipsoid_at",
    "given_jacobian",
    "lost_directions_at",
    "nullspace_at",
    "plan_of",
    "singular_values_at",
    "singularities_at",
]

LOST = 1e-6
"""Singular value below which a direction counts as lost (m or 1 per rad)."""
PLAN = ArrayObject(int64, (4,))
Compiled = Callable[..., Any]
Prepared = tuple[Compiled, NDArray[np.int64], Any]
"""What a verb keeps for an arm: compiled code, plan, results to take after."""


def asked_for(signature: Any) -> Callable[[Compiled], Callable[[], Compiled]]:
    """What compiles a function of Python objects when it is first asked for."""

    def decorate(function: Compiled) -> Callable[[], Compiled]:
        return functools.cache(lambda: direct(loop(signature, error_model="numpy")(function)))

    return decorate


def plan_of(arm: SolvedArm, part: str = "all", frame: str = "world") -> NDArray[np.int64]:
    """Address of the arm's Jacobian in C form, count of joints, first row of the part, count of its rows."""
    rows = rows_of(part)
    return np.array([arm.kernel("jacobian", frame=frame).address, arm.n, rows.start, rows.stop - rows.start])


@loop(error_model="numpy")
def given_jacobian(plan: Any, q: Array, J: Array) -> bool:
    """Write the Jacobian at q to the beginning of J (ROOM,), unless q is not finite or of another length."""
    n = plan[1]
    total = 0.0
    for x in q:
        total += x
    if q.shape[0] != n or not math.isfinite(total) or room_for(6, n) > ROOM:
        return False
    call_kernel(plan[0], q, J)
    return True


@loop(error_model="numpy")
def _part(plan: Any, J: Array) -> Array:
    n, first, rows = plan[1], plan[2], plan[3]
    return J[n * first : n * (first + rows)].reshape(rows, n)


@loop(error_model="numpy")
def _count(s: Array, tolerance: float) -> int:
    count = 0
    for x in s:
        count += x > tolerance
    return count


_LIST, _TABLE = ArrayObject(float64, (None,)), ArrayObject(float64, (None, None))
_ELLIPSOID, _TABLES = Results([_TABLE, _LIST]), Results([_TABLE])


@asked_for(_LIST(PLAN, _LIST, _LIST))
def singular_values_at(plan: Any, q: Any, like: Any) -> Any:
    """Singular values, in an array like the one given."""
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        decompose(_part(array_of(plan), J), room, array_of(result), False)
    return result


@loop(error_model="numpy")
def _left_after(A: Array, room: Array, rank: int, first: int, rows: Array) -> None:
    """Write left vectors of a decomposed A (m, n), one in each of `rows` (m, m), from a first one on or all."""
    m, n = A.shape
    if m <= n:
        rows_of_turns(room, n, m, first, rows[first:])
    else:
        unit_rows(room, m, 0, rank, rows)
        complete(rows, rank)


@asked_for(_ELLIPSOID(PLAN, _LIST, boolean, _ELLIPSOID))
def ellipsoid_at(plan: Any, q: Any, of_forces: bool, like: Any) -> Any:
    """Axes and radii of the ellipsoid of velocities or forces, in a tuple like the one given."""
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        A, axes, radii = _part(array_of(plan), J), array_of(entry(result, 0)), array_of(entry(result, 1))
        m, n = A.shape
        s, rows = J[ROOM - m :], J[ROOM - m - m * m : ROOM - m].reshape(m, m)
        s[:] = 0.0
        rank = decompose(A, room, s[: min(m, n)], m <= n)
        _left_after(A, room, rank, 0, rows)
        for i in range(m):
            at = m - 1 - i if of_forces else i
            radii[at] = s[i] if not of_forces else (1.0 / s[i] if s[i] > LOST else np.inf)
            for j in range(m):
                axes[j, at] = rows[i, j]
    return result


@asked_for(_TABLE(PLAN, _LIST, float64, _TABLES))
def lost_directions_at(plan: Any, q: Any, tolerance: float, likes: Any) -> Any:
    """Left vectors (k, m) of singular values up to the tolerance, in an array like `likes[k]`."""
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(entry(likes, 0))
    A = _part(array_of(plan), J)
    m, n = A.shape
    s, rows = J[ROOM - min(m, n) :], J[ROOM - m - m * m : ROOM - m].reshape(m, m)
    rank = decompose(A, room, s, m <= n)
    kept = _count(s, tolerance)
    result = made_like(entry(likes, m - kept))
    if exists(result) and kept < m:
        found = array_of(result)
        _left_after(A, room, rank, kept, rows)
        for i in range(kept, m):
            for j in range(m):
                found[i - kept, j] = rows[i, j]
    return result


@loop(error_model="numpy", fastmath={"contract"})
def _complement(room: Array, first: Any, second: Any, N: Array) -> None:
    """Write orthonormal columns N (n, count) at right angles to rows in room: Gram-Schmidt, twice, of axes.

    first, second: of each row 1 / |row|^2, or 0 if it does not count.
    """
    n = N.shape[0]
    for c in range(N.shape[1]):
        axis, least = 0, np.inf
        for k in range(n):
            x, y = load(room, 2 * k), load(room, 2 * k + 1)
            covered = total(first * (x * x) + second * (y * y))
            for i in range(c):
                covered += N[k, i] * N[k, i]
            if covered < least:
                axis, least = k, covered
        for k in range(n):
            N[k, c] = 1.0 if k == axis else 0.0
        for _ in range(2):
            x, y = spread(0.0), spread(0.0)
            for k in range(n):
                x, y = x + N[k, c] * load(room, 2 * k), y + N[k, c] * load(room, 2 * k + 1)
            x, y = first * x, second * y
            for k in range(n):
                N[k, c] -= total(x * load(room, 2 * k) + y * load(room, 2 * k + 1))
            for i in range(c):
                along = 0.0
                for k in range(n):
                    along += N[k, i] * N[k, c]
                for k in range(n):
                    N[k, c] -= along * N[k, i]
        square = 0.0
        for k in range(n):
            square += N[k, c] * N[k, c]
        for k in range(n):
            N[k, c] /= math.sqrt(square)


@asked_for(_TABLE(PLAN, _LIST, float64, _TABLES))
def nullspace_at(plan: Any, q: Any, tolerance: float, likes: Any) -> Any:
    """Right vectors (n, k) of singular values up to the tolerance, in an array like `likes[k]`."""
    J, room = scratch(ROOM), scratch(ROOM)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(entry(likes, 0))
    A = _part(array_of(plan), J)
    m, n = A.shape
    s = J[ROOM - min(m, n) :]
    rank = decompose(A, room, s, m > n)
    kept = _count(s, tolerance)
    result = made_like(entry(likes, n - kept))
    if exists(result) and kept < n:
        found = array_of(result)
        if m > n:
            rows_of_turns(room, m, n, kept, found.T)
        else:
            first, second = weights(room, n, min(kept, rank))
            _complement(room, first, second, found)
    return result


_SINGULARITIES = Results([])
_LIKES = Results([_SINGULARITIES, Results([_SINGULARITIES]), _LIST])


@asked_for(_SINGULARITIES(PLAN, _LIST, float64, int64, _LIKES))
def singularities_at(plan: Any, q: Any, tolerance: float, measures: int, likes: Any) -> Any:
    """Singularities, nearest first, in a tuple.

    measures
        Address of the kernel of the named ones, or 0: then the smallest singular value is the only one.
    likes
        A tuple of as many; of each name a singularity that is not near, without a direction; a direction.
    """
    J, room, values = scratch(ROOM), scratch(ROOM), scratch(4)
    if not (fits(plan) and fits(q) and given_jacobian(array_of(plan), array_of(q), J)):
        return nothing(entry(likes, 0))
    A = _part(array_of(plan), J)
    m, n = A.shape
    k, rank, count, near = min(m, n), 0, 3, False
    s, rows = J[ROOM - k :], J[ROOM - m - m * m : ROOM - m].reshape(m, m)
    if measures != 0:
        call_kernel(measures, array_of(q), values)
    else:
        count, rank = 1, decompose(A, room, s, m <= n)
        values[0] = s[k - 1]
    for i in range(count):
        near = near or abs(values[i]) < tolerance
    result = made_like(entry(likes, 0))
    direction = made_like(entry(likes, 2)) if near else nothing(entry(likes, 2))
    whole = exists(result) and exists(direction)
    if near and whole:
        if measures != 0:
            rank = decompose(A, room, s, m <= n)
        _left_after(A, room, rank, k - 1, rows)
        array_of(direction)[:] = rows[k - 1]
    for place in range(count):
        nearest = 0
        for i in range(1, count):
            if abs(values[i]) < abs(values[nearest]):
                nearest = i
        if whole:
            value = values[nearest]
            one = made_like(entry(entry(likes, 1), nearest))
            whole = exists(one) and put(one, 1, value)
            if whole and abs(value) < tolerance:
                whole = put(one, 2, True) and put(one, 3, direction)
            whole = whole and put(result, place, one)
            release(one)
        values[nearest] = np.inf
    release(direction)
    return result if whole else release(result)
