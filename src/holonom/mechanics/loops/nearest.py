"""Which branch of a closed-form inverse is nearest to given joints, in compiled code: one target, or rows of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import float64, int8, int64, void
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mechanics.kernels.inverse.geometry import LIMIT, UNREACHABLE
from holonom.trace.call.direct import ArrayObject, array_of, direct, fits, scratch
from holonom.trace.call.pointer import call_kernel
from holonom.trace.call.results import Results, entry, exists, made_like, nothing
from holonom.trace.code.loops import loop

__all__ = ["nearest_of_rows", "nearest_point", "nearest_pose"]

_LIST, _TABLE, _STACK = float64[::1], float64[:, ::1], float64[:, :, ::1]

ROOM = 256
"""Numbers that the branches of one target may be, all joints and status, and the joints taken; none has as many."""


@loop(error_model="numpy")
def _turned(value: float, reference: float, lower: float, upper: float, turn: float) -> float:
    """The value whole turns nearer to the reference, where that stays within the limits."""
    if abs(reference - value) > 0.5 * turn and turn > 0.0:
        moved = value + turn * np.rint((reference - value) / turn)
        if lower <= moved <= upper:
            return float(moved)
    return value


@loop(error_model="numpy")
def _choose(branches: Array, status: Any, at: int, reference: Array, joints: Array, q: Array) -> int:
    """Write the nearest of the branches (k, n) to q (n,), and return its number; see `nearest_of_rows`.

    `status[at : at + k]` are theirs. Ranks first: within the limits, outside them, out of reach.
    """
    n = q.shape[0]
    best, least, rank = 0, np.inf, 3
    for branch in range(branches.shape[0]):
        code = status[at + branch]
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
    return best


def _nearest(address: int, count: int, target: Any, reference: Any, joints: Any, answers: Any) -> Any:
    """Solve and choose for one target.

    Parameters
    ----------
    address
        Of the C form of the arm's inverse geometry.
    count
        Of its branches.
    target
        T (4, 4) or p (3,).
    reference, joints
        As in `nearest_of_rows`, of one row.
    answers
        What to return for each status of each branch: one like number 4 * branch + status, its array the joints.

    Returns
    -------
    None if something is not finite, or no array of its shape.
    """
    if not (fits(target) and fits(reference) and fits(joints)):
        return nothing(entry(answers, 0))
    goal, start, bounds = array_of(target), array_of(reference), array_of(joints)
    n = bounds.shape[1]
    total = 0.0
    for x in goal.flat:
        total += x
    for x in start:
        total += x
    if start.shape[0] != n or count * (n + 1) + n > ROOM or not math.isfinite(total):
        return nothing(entry(answers, 0))
    found = scratch(ROOM)
    call_kernel(address, goal, found)
    q = found[ROOM - n :]
    branch = _choose(found[: count * n].reshape(count, n), found, count * n, start, bounds, q)
    result = made_like(entry(answers, 4 * branch + int(found[count * n + branch])))
    if exists(result):
        array_of(entry(result, 0))[:] = q
    return result


def _compiled(*target: int) -> Callable[..., Any]:
    listed, table = ArrayObject(float64, (None,)), ArrayObject(float64, (4, None))
    answer = Results([listed])
    kind = answer(int64, int64, ArrayObject(float64, target), listed, table, Results([answer]))
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
        Written: joints (N, n), status and number (N,) of the branch taken.
    """
    for row in range(branches.shape[0]):
        number[row] = _choose(branches[row], status[row], 0, reference[row], joints, q[row])
        taken[row] = status[row, number[row]]
