"""Which branch of a closed-form inverse is nearest to given joints, in compiled code: one target, or rows of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import float64, int8, int64, void
from numpy.typing import NDArray

from holonom.arrays import REVOLUTION, Array
from holonom.mechanics.kernels.inverse.geometry import LIMIT, SINGULAR, SINGULAR_LIMIT, UNREACHABLE
from holonom.model import LIMIT_TOLERANCE
from holonom.trace.call.direct import ArrayObject, array_of, direct, fits, scratch
from holonom.trace.call.pointer import call_kernel
from holonom.trace.call.results import Results, entry, exists, made_like, nothing
from holonom.trace.code.loops import loop

__all__ = ["LOCAL", "NEAR", "STATUSES", "STEEP", "nearest_of_rows", "nearest_point", "nearest_pose"]

_LIST, _TABLE, _STACK = float64[::1], float64[:, ::1], float64[:, :, ::1]

NEAR, STEEP, LOCAL = 1e-6, 5.0, 0.5
"""A branch farther from the reference (rad or m) than the first, and than so many times what that misses the target by,
is doubted, where the reference keeps the limits and misses by less than the last (m, entries of the rotation): close
to a singular pose a nearer one may be lost in rounding, or in what a calibrated arm is off."""
STATUSES = 5
"""Of the kernel."""
ROOM = 256
"""Numbers that the branches of one target may be, all joints and status, and the joints taken; none has as many."""


@loop(error_model="numpy")
def _turned(value: float, reference: float, lower: float, upper: float, turn: float) -> float:
    """The value that is whole turns away and nearest to the reference, of those within the limits."""
    if abs(reference - value) > 0.5 * turn and turn > 0.0:
        least = np.ceil((lower - LIMIT_TOLERANCE - value) / turn)
        most = np.floor((upper + LIMIT_TOLERANCE - value) / turn)
        if least <= most:
            return float(value + turn * min(max(np.rint((reference - value) / turn), least), most))
    return value


@loop(error_model="numpy")
def _choose(branches: Array, status: Any, at: int, reference: Array, joints: Array, q: Array) -> int:
    """Write the nearest of the branches (k, n) to q (n,), and return its number, -1 if a joint is free in one of them.

    `status[at : at + k]` are theirs. Ranks first: within the limits, outside them, out of reach.
    """
    n = q.shape[0]
    best, least, rank, free = 0, np.inf, 3, False
    for branch in range(branches.shape[0]):
        code = status[at + branch]
        free = free or code in (SINGULAR, SINGULAR_LIMIT)
        worse = 2 if code == UNREACHABLE else (1 if code == LIMIT else 0)
        if worse > rank:
            continue
        distance = 0.0
        for i in range(n):
            value = _turned(branches[branch, i], reference[i], joints[0, i], joints[1, i], joints[2, i])
            distance = max(distance, joints[3, i] * abs(value - reference[i]))
        if worse < rank or distance < least:
            best, least, rank = branch, distance, worse
    for i in range(n):
        q[i] = _turned(branches[best, i], reference[i], joints[0, i], joints[1, i], joints[2, i])
    return -1 if free else best


@loop(error_model="numpy")
def _missed(address: int, q: Array, goal: Array) -> float:
    """By how much (m, or an entry of the rotation) joints miss a target: T (16,), or p (3,)."""
    T = scratch(16)
    call_kernel(address, q, T)
    missed = 0.0
    for i in range(goal.shape[0]):
        missed = max(missed, abs(T[i if goal.shape[0] == 16 else 4 * i + 3] - goal[i]))
    return missed


def _nearest(address: int, forward: int, count: int, target: Any, reference: Any, joints: Any, answers: Any) -> Any:
    """Solve and choose for one target.

    Parameters
    ----------
    address
        Of the C form of the arm's inverse geometry.
    forward
        The same of its forward kinematics.
    count
        Of its branches.
    target
        T (4, 4) or p (3,).
    reference, joints
        As in `nearest_of_rows`, of one row.
    answers
        What to return for each status of each branch: one like number STATUSES * branch + status, its array the joints.

    Returns
    -------
    None if something is not finite, or no array of its shape, or where a joint is free in a branch, or
    the one chosen is doubted (see `STEEP`).
    """
    if not (fits(target) and fits(reference) and fits(joints)):
        return nothing(entry(answers, 0))
    goal, start, bounds = array_of(target), array_of(reference), array_of(joints)
    n = bounds.shape[1]
    total = 0.0
    for x in goal.flat:
        total += x
    for x in start:
        total += x if abs(x) <= REVOLUTION else np.inf
    if start.shape[0] != n or count * (n + 1) + n > ROOM or not math.isfinite(total):
        return nothing(entry(answers, 0))
    found = scratch(ROOM)
    call_kernel(address, goal, found)
    q = found[ROOM - n :]
    branch = _choose(found[: count * n].reshape(count, n), found, count * n, start, bounds, q)
    if branch < 0:
        return nothing(entry(answers, 0))
    apart, inside = 0.0, True
    for i in range(n):
        apart = max(apart, abs(q[i] - start[i]))
        inside = inside and bounds[0, i] - LIMIT_TOLERANCE <= start[i] <= bounds[1, i] + LIMIT_TOLERANCE
    if apart > NEAR and inside:
        missed = _missed(forward, start, goal.reshape(goal.size))
        if missed < LOCAL and apart > STEEP * missed:
            return nothing(entry(answers, 0))
    result = made_like(entry(answers, STATUSES * branch + int(found[count * n + branch])))
    if exists(result):
        array_of(entry(result, 0))[:] = q
    return result


def _compiled(*target: int) -> Callable[..., Any]:
    listed, table = ArrayObject(float64, (None,)), ArrayObject(float64, (4, None))
    answer = Results([listed])
    kind = answer(int64, int64, int64, ArrayObject(float64, target), listed, table, Results([answer]))
    return direct(loop(kind, error_model="numpy")(_nearest))


nearest_pose, nearest_point = _compiled(4, 4), _compiled(3)


@loop(
    void(_STACK, int8[:, ::1], _TABLE, _TABLE, _TABLE, int8[::1], int64[::1]),
    nogil=True,
    error_model="numpy",
)
def nearest_of_rows(
    branches: Array,
    status: NDArray[np.int8],
    reference: Array,
    joints: Array,
    q: Array,
    taken: NDArray[np.int8],
    number: NDArray[np.int64],
) -> None:
    """Choose for rows of branches (N, k, n) with status (N, k).

    Parameters
    ----------
    reference
        Joints (N, n) to stay near to.
    joints
        (4, n): lower and upper limits, 2 pi for joints that turn and 0 for those that slide, weights.
    q, taken, number
        Written: joints (N, n), status and number (N,) of the branch taken; number -1 where a joint is free in a branch.
    """
    for row in range(branches.shape[0]):
        number[row] = _choose(branches[row], status[row], 0, reference[row], joints, q[row])
        taken[row] = status[row, max(number[row], 0)]
