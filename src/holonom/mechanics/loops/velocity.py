"""Joint rates for a twist by the singular values of the Jacobian, in compiled code."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import float64, int64

from holonom.arrays import Array
from holonom.numeric.jacobi_kernels import COLUMN, FACTOR, SQUARE, laid_out, orthogonalise, slot
from holonom.numeric.svd_kernels import ROOM, room_for
from holonom.trace.call.direct import ArrayObject, array_of, direct, fits, scratch
from holonom.trace.call.pointer import call_kernel
from holonom.trace.call.results import exists, made_like, nothing
from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import largest, load, spread, total

__all__ = ["AUTO", "rates_of_one", "rates_of_rows"]

PLAN = ArrayObject(int64, (2,))

AUTO = -1.0
"""Damping that follows the smallest singular value."""
NEAR = 0.02
"""Smallest singular value, as a share of the largest one, below which automatic damping sets in."""
LOST = 1e-12
"""Singular value, as a share of the largest one, below which a direction is lost altogether."""


@loop(error_model="numpy")
def _rates(J: Array, twist: Array, damping: float, room: Array, qd: Array) -> None:
    """Sum of s / (s^2 + lambda^2) v u^T twist over the singular values s of J (6, n).

    lambda = `damping`, or if it is `AUTO` as `velocity.joint_rates` says. The rows of J become s v^T, and the twist,
    turned with them, u^T twist; of fewer joints than rows the columns become s u, and the axes, turned with them, v.
    """
    m, n = J.shape
    k, columns, more = min(m, n), max(m, n), 1 if m <= n else n
    unit = laid_out(J, room, more)
    if m <= n:
        for i in range(m):
            room[COLUMN * n + slot(i, m)] = twist[i]
    else:
        for i in range(n):
            room[COLUMN * (m + i) + slot(i, n)] = 1.0
    orthogonalise(room, k, columns, more)
    squares, factors = columns + more + SQUARE, columns + more + FACTOR
    first, second = load(room, 2 * squares), load(room, 2 * squares + 1)  # s^2
    most = largest(max(first, second))
    square = damping * damping / (unit * unit)
    if damping == AUTO:
        least = most
        for at in range(COLUMN):
            length = room[COLUMN * squares + at]
            if 0.0 <= length < least:
                least = length
        square = max(NEAR * NEAR * most - least, 0.0)
    x, y = spread(0.0), spread(0.0)
    if m <= n:
        x, y, start = load(room, 2 * n), load(room, 2 * n + 1), 0
    else:
        for i in range(m):
            x, y = x + twist[i] * load(room, 2 * i), y + twist[i] * load(room, 2 * i + 1)
        start = m
    p, q = load(room, 2 * factors), load(room, 2 * factors + 1)
    limit, zero = LOST * LOST * most, spread(0.0)
    x = select(first > limit, p * p * x / ((first + square) * unit), zero)
    y = select(second > limit, q * q * y / ((second + square) * unit), zero)
    for j in range(n):
        qd[j] = total(x * load(room, 2 * (start + j)) + y * load(room, 2 * (start + j) + 1))


@loop(nogil=True, error_model="numpy")
def rates_of_rows(J: Array, twist: Array, damping: float, qd: Array) -> None:
    """The rates of rows: J (N, 6, n), twist (N, 6), qd (N, n)."""
    room = np.empty(room_for(*J.shape[1:]))
    for row in range(J.shape[0]):
        _rates(J[row], twist[row], damping, room, qd[row])


@loop(error_model="numpy")
def _jacobian(plan: Any, q: Array, J: Array) -> bool:
    """Write the Jacobian at q to the beginning of J (ROOM,), unless q is not finite or of another length."""
    n = plan[1]
    total = 0.0
    for x in q:
        total += x
    if q.shape[0] != n or not math.isfinite(total) or room_for(6, n) > ROOM:
        return False
    call_kernel(plan[0], q, J)
    return True


_LIST = ArrayObject(float64, (None,))


def _rates_of_one(plan: Any, q: Any, twist: Any, damping: float, like: Any) -> Any:
    """Rates of one sample, in an array like the one given; None if something is not finite or of another shape.

    The plan is the address of the arm's Jacobian in C form, and the count of its joints.
    """
    if not (fits(plan) and fits(q) and fits(twist)):
        return nothing(like)
    J, room, wanted = scratch(ROOM), scratch(ROOM), array_of(twist)
    size = 0.0
    for x in wanted:
        size += x
    if not math.isfinite(size) or not _jacobian(array_of(plan), array_of(q), J):
        return nothing(like)
    result = made_like(like)
    if exists(result):
        n = array_of(q).shape[0]
        _rates(J[: 6 * n].reshape(6, n), wanted, damping, room, array_of(result))
    return result


@functools.cache
def rates_of_one() -> Callable[..., Any]:
    """`_rates_of_one`, compiled when it is first asked for."""
    kind = _LIST(PLAN, _LIST, ArrayObject(float64, (6,)), float64, _LIST)
    return direct(loop(kind, error_model="numpy")(_rates_of_one))
