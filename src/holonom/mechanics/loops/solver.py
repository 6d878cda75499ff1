"""The compiled search of the numerical inverse: one loop for every arm, which comes in as the address of its kernel.

Levenberg-Marquardt on the pose error (damping proportional to its square, after Chan & Lawrence 1988), joints held
inside their limits by an active set, restarts from a low-discrepancy sequence, then, where asked, a climb of a
criterion in the nullspace. No checks here, no allocation in the inner loops.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import REVOLUTION, Array
from holonom.mechanics.loops.pose_check import is_rigid
from holonom.model import LIMIT_TOLERANCE
from holonom.trace.call.pointer import call_kernel
from holonom.trace.code.loops import loop

__all__ = [
    "LIMIT",
    "NOT_CONVERGED",
    "OK",
    "Chain",
    "Search",
    "damped_step",
    "scratch",
    "solve_one",
    "solve_rows",
]

OK, NOT_CONVERGED, LIMIT = 0, 1, 2

DAMPING = 0.03
"""Damping of a step per square of the weighted error."""
LARGEST_STEP = 1.0
"""Largest step of a joint that turns, rad; what slides moves in proportion, as far as it has to."""
FARTHEST = 12.0
"""Weighted square of the error from which on damping grows no more: half a turn, and two arm's lengths away."""
STALL = 0.8
"""A step that leaves more than this share of the squared error is a poor one; three in a row end an attempt."""
CLIMB_ROUNDS, CLIMB_STEP, CLIMB_END = 60, 0.1, 1e-6
"""Rounds of the nullspace climb, its first and last step (largest joint change, rad or m)."""


class Chain(NamedTuple):
    """An arm, as arrays (n,): joints move within `lower` .. `upper`.

    Restarts are drawn from `origin` + [0, 1) `span` by the additive sequence of `stride`; a joint at its limit may be
    turned by `turn` (0: not). `turns` is 1 for joints that turn, 0 for those that slide.
    """

    lower: Array
    upper: Array
    origin: Array
    span: Array
    stride: Array
    turn: Array
    turns: Array


class Search(NamedTuple):
    """How to search.

    `task`, `multipliers`, `criterion`: addresses of the kernels of `kernels.pose` (criterion 0: none); `weights` of the
    six error rows, and what the task's kernel takes after them (`SolvedArm.pointer`); `first`: number of the sequence's
    first point.
    """

    task: int
    multipliers: int
    criterion: int
    weights: Array
    tolerance: float
    attempts: int
    steps: int
    first: int


class _Room(NamedTuple):
    """Scratch of one thread. Sources and targets of the kernels hold their inputs and outputs in a row."""

    q: Array
    best: Array
    climbed: Array
    step: Array
    free: Array
    source: Array
    state: Array
    trial: Array
    normal: Array
    y: Array
    posture: Array
    slope: Array


@loop(error_model="numpy")
def scratch(n: int, weights: int) -> Any:
    """Return the room that one thread needs for an arm of n joints and so many weights."""
    return _Room(
        np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n + 12 + weights),
        np.zeros(28 + 6 * n), np.zeros(28 + 6 * n), np.zeros(28), np.zeros(6), np.zeros(2 * n), np.zeros(n + 1),
    )  # fmt: skip


@loop(error_model="numpy")
def _copy(a: Array, first: int, count: int, b: Array, at: int) -> None:
    """b[at : at + count] = a[first : first + count]; assigning slices compiles ten times as long."""
    for k in range(count):
        b[at + k] = a[first + k]


@loop(error_model="numpy")
def damped_step(address: int, state: Array, free: Array, damping: float, room: Any) -> None:
    """room.step = J^T (J J^T + damping)^-1 x over the free joints, x being what stands at room.normal[21:27]."""
    n = free.shape[0]
    normal, y, step = room.normal, room.y, room.step
    _copy(state, 7 + 6 * n, 21, normal, 0)
    for k in range(n):
        if free[k] == 0.0:
            place = 0
            for i in range(6):
                for j in range(i + 1):
                    normal[place] -= state[7 + 6 * k + i] * state[7 + 6 * k + j]
                    place += 1
    normal[27] = damping
    call_kernel(address, normal, y)
    for k in range(n):
        total = 0.0
        for i in range(6):
            total += state[7 + 6 * k + i] * y[i]
        step[k] = total * free[k]


@loop(error_model="numpy")
def _release(q: Array, lower: Array, upper: Array, state: Array, free: Array) -> bool:
    """Free all joints but those at a limit that J^T e drives further out; return whether there is such a joint."""
    pressed = False
    for k in range(q.shape[0]):
        free[k] = 1.0
        if q[k] <= lower[k] or q[k] >= upper[k]:
            slope = 0.0
            for i in range(6):
                slope += state[7 + 6 * k + i] * state[1 + i]
            if (slope < 0.0) == (q[k] <= lower[k]):
                free[k], pressed = 0.0, True
    return pressed


@loop(error_model="numpy")
def _move(chain: Any, q: Array, step: Array, scale: float, moved: Array) -> None:
    """q + scale step, a turn back or else clamped where that leaves the limits."""
    lower, upper, turn = chain.lower, chain.upper, chain.turn
    for k in range(q.shape[0]):
        value = q[k] + scale * step[k]
        if value > upper[k]:
            value = value - turn[k] if turn[k] > 0.0 and value - turn[k] >= lower[k] else upper[k]
        elif value < lower[k]:
            value = value + turn[k] if turn[k] > 0.0 and value + turn[k] <= upper[k] else lower[k]
        moved[k] = value


@loop(error_model="numpy")
def _cost(state: Array) -> float:
    total = 0.0
    for i in range(1, 7):
        total += state[i] * state[i]
    return total


@loop(error_model="numpy")
def _largest(a: Array) -> float:
    largest = 0.0
    for x in a:
        largest = max(largest, abs(x))
    return largest


@loop(error_model="numpy")
def _largest_turn(chain: Any, step: Array) -> float:
    largest = 0.0
    for k in range(step.shape[0]):
        largest = max(largest, chain.turns[k] * abs(step[k]))
    return largest


@loop(error_model="numpy")
def _evaluate(search: Any, q: Array, room: Any) -> float:
    """Put the task at q into `room.state`; return the residual squared. The goal stands in `room.source`."""
    _copy(q, 0, q.shape[0], room.source, 0)
    call_kernel(search.task, room.source, room.state)
    return float(room.state[0])


@loop(error_model="numpy")
def _descend(chain: Any, search: Any, room: Any) -> tuple[float, int, bool]:
    """One attempt from `room.q`: residual squared, steps taken, whether joints ended pressed against limits."""
    q, state, trial, source, free, normal = room.q, room.state, room.trial, room.source, room.free, room.normal
    n, enough = q.shape[0], search.tolerance * search.tolerance
    _evaluate(search, q, room)
    cost, boost, poor, steps, pressed = _cost(state), 1.0, 0, 0, False
    while state[0] > enough and steps < search.steps and poor < 3:
        steps += 1
        pressed = _release(q, chain.lower, chain.upper, state, free)
        _copy(state, 1, 6, normal, 21)
        damped_step(search.multipliers, state, free, DAMPING * min(cost, FARTHEST) * boost, room)
        _move(chain, q, room.step, min(1.0, LARGEST_STEP / (_largest_turn(chain, room.step) + 1e-300)), source)
        call_kernel(search.task, source, trial)
        trial_cost = _cost(trial)
        poor = poor + 1 if trial_cost > STALL * cost else 0
        if trial_cost < cost:
            _copy(source, 0, n, q, 0)
            _copy(trial, 0, state.shape[0], state, 0)
            cost, boost = trial_cost, max(1.0, 0.3 * boost)
        else:
            boost *= 8.0
    return state[0], steps, pressed


@loop(error_model="numpy")
def _criterion(search: Any, q: Array, room: Any) -> float:
    """Value of the criterion; its gradient goes to `room.slope[1:]`."""
    _copy(q, 0, q.shape[0], room.posture, 0)
    call_kernel(search.criterion, room.posture, room.slope)
    return float(room.slope[0])


@loop(error_model="numpy")
def _along_nullspace(chain: Any, search: Any, room: Any) -> None:
    """room.step = (1 - J^+ J) dH/dq at room.climbed, without the joints at limits that it drives out."""
    n = room.q.shape[0]
    state, slope, free, step, at = room.state, room.slope, room.free, room.step, room.climbed
    for k in range(n):
        free[k] = 1.0
    pressed = True
    while pressed:
        for i in range(6):
            total = 0.0
            for k in range(n):
                total += state[7 + 6 * k + i] * slope[1 + k] * free[k]
            room.normal[21 + i] = total
        damped_step(search.multipliers, state, free, 0.0, room)
        pressed = False
        for k in range(n):
            step[k] = (slope[1 + k] - step[k]) * free[k]
            if (at[k] <= chain.lower[k] and step[k] < 0.0) or (at[k] >= chain.upper[k] and step[k] > 0.0):
                free[k], pressed = 0.0, True


@loop(error_model="numpy")
def _climb(chain: Any, search: Any, room: Any) -> int:
    """From the solution in `room.q`, climb the criterion in the nullspace; every point kept is a solution itself."""
    total, reach = 0, CLIMB_STEP
    n = room.q.shape[0]
    _copy(room.q, 0, n, room.climbed, 0)
    height = _criterion(search, room.q, room)
    for _ in range(CLIMB_ROUNDS):
        _evaluate(search, room.climbed, room)
        _along_nullspace(chain, search, room)
        largest = _largest(room.step)
        if reach < CLIMB_END or largest < 1e-9:
            break
        _move(chain, room.climbed, room.step, reach / largest, room.q)
        residual, steps, _ = _descend(chain, search, room)
        total += steps + 1
        higher = _criterion(search, room.q, room)
        if residual <= search.tolerance * search.tolerance and higher > height:
            _copy(room.q, 0, n, room.climbed, 0)
            height, reach = higher, 1.5 * reach
        else:
            reach *= 0.3
            _criterion(search, room.climbed, room)
    _copy(room.climbed, 0, n, room.q, 0)
    return total


@loop(error_model="numpy")
def _restart(chain: Any, number: int, q: Array) -> None:
    """Point `number` of the additive sequence (Roberts 2018) in the box of restarts; point 0 is its middle."""
    for k in range(q.shape[0]):
        u = 0.5 + number * chain.stride[k]
        q[k] = chain.origin[k] + (u - math.floor(u)) * chain.span[k]


@loop(error_model="numpy")
def _solve(chain: Any, search: Any, room: Any, starts: Array, preferred: Array, row: int) -> tuple[float, int, bool]:
    """Solve for the goal in `room.source`, to `room.best`: residual squared, steps taken, whether pressed to limits."""
    n, given = chain.lower.shape[0], min(starts.shape[0], 1)
    enough = search.tolerance * search.tolerance
    least, blocked, total = np.inf, False, 0
    for attempt in range(search.attempts):
        if attempt < given:
            _copy(starts, n * row, n, room.q, 0)
        else:
            _restart(chain, search.first + attempt - given, room.q)
        found, steps, pressed = _descend(chain, search, room)
        total += steps
        if found < least:
            least, blocked = found, pressed
            _copy(room.q, 0, n, room.best, 0)
        if found <= enough:
            break
    if least <= enough and search.criterion != 0:
        _copy(preferred, n * row, n, room.posture, n)
        total += _climb(chain, search, room)
        _copy(room.q, 0, n, room.best, 0)
    return _evaluate(search, room.best, room), total, blocked


@loop(error_model="numpy")
def _status(search: Any, least: float, blocked: bool) -> int:
    if least <= search.tolerance * search.tolerance:
        return OK
    return LIMIT if blocked else NOT_CONVERGED


@loop(error_model="numpy", nogil=True)
def solve_rows(
    chain: Any,
    search: Any,
    goals: Array,
    starts: Array,
    preferred: Array,
    q: Array,
    status: NDArray[np.int8],
    residual: Array,
    iterations: NDArray[np.int64],
    first: int,
    last: int,
) -> None:
    """Solve rows first .. last of goals (12 N,); starts (n N,) or (0,); preferred (n N,) or (0,); to q (n N,)."""
    n = chain.lower.shape[0]
    count = search.weights.shape[0]
    room = scratch(n, count)
    _copy(search.weights, 0, count, room.source, n + 12)
    for row in range(first, last):
        _copy(goals, 12 * row, 12, room.source, n)
        least, total, blocked = _solve(chain, search, room, starts, preferred, row)
        _copy(room.best, 0, n, q, n * row)
        residual[row], iterations[row] = math.sqrt(least), total
        status[row] = _status(search, least, blocked)


@loop(error_model="numpy", nogil=True)
def solve_one(
    limits: Array,
    numbers: Array,
    whole: NDArray[np.int64],
    bounded: bool,
    T: Array,
    start: Array,
    preferred: Array,
    q: Array,
    residual: Array,
) -> int:
    """Solve for one pose T (4, 4), from `start`: (n,), or (0,) for none, as `preferred`.

    The fields of `Chain` come as the rows of `limits`, those of `Search` as `whole` and `numbers` (tolerance, then
    weights), for arrays go through faster than records. q (n,) and residual (1,) are written.

    All arrays are C-contiguous, of float64 (`whole`: int64).

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
        if not abs(start[k]) <= REVOLUTION:
            return -1
        if bounded and not limits[0, k] - LIMIT_TOLERANCE <= start[k] <= limits[1, k] + LIMIT_TOLERANCE:
            return -1
    chain = Chain(limits[0], limits[1], limits[2], limits[3], limits[4], limits[5], limits[6])
    search = Search(whole[0], whole[1], whole[2], numbers[1:], numbers[0], whole[3], whole[4], whole[5])
    room = scratch(n, search.weights.shape[0])
    for i in range(3):
        room.source[n + 4 * i : n + 4 * i + 4] = T[i]
    room.source[n + 12 :] = search.weights
    least, total, blocked = _solve(chain, search, room, start, preferred, 0)
    q[:] = room.best
    residual[0] = math.sqrt(least)
    return 4 * total + _status(search, least, blocked)
