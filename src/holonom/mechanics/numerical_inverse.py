"""Numerical inverse kinematics of any chain: Levenberg-Marquardt with joint limits, restarts and nullspace criteria."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, real_array
from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mechanics.arm.nearest import joint_vectors
from holonom.mechanics.equations.criteria import CRITERIA, Criterion
from holonom.mechanics.kernels.pose import multipliers_kernel
from holonom.mechanics.kernels.protocol import SolvedArm
from holonom.model import ArmModel, outside, reach
from holonom.spatial import check_pose
from holonom.trace import check_threads, share

if TYPE_CHECKING:
    from holonom.mechanics.loops.solver import Chain, Search

__all__ = ["InverseResult", "InverseSolver", "InverseStatus", "free_turns", "inverse_solver", "solve_inverse"]

FAR = 20.0
"""Width of limits over the arm's reach (half a turn) up to which they say where a joint may be found."""
LEAST_CHUNK, CHUNKS = 64, 8
"""Poses that a thread takes at a time, at least; else a share of the batch, so that hard poses spread over threads."""


class InverseStatus(IntEnum):
    """What became of a pose."""

    OK = 0
    NOT_CONVERGED = 1
    LIMIT = 2


class InverseResult(NamedTuple):
    """Joint vectors for poses.

    q : (..., n) rad or m; status : (...) int8, an `InverseStatus`; residual : (...) length of the pose error (m and
    rad, the rows that count); iterations : (...) steps over all attempts.
    OK: the pose of q was computed and lies within the tolerance. Else q is the best that was found: NOT_CONVERGED, or
    LIMIT where that search ended pressed against joint limits.
    """

    q: Array
    status: NDArray[np.int8]
    residual: Array
    iterations: NDArray[np.int64]


def solve_inverse(
    arm: SolvedArm,
    T: ArrayLike,
    q0: ArrayLike | None = None,
    *,
    limits: bool = True,
    tolerance: float = 1e-6,
    restarts: int = 200,
    steps: int = 30,
    weights: ArrayLike | None = None,
    weights_frame: str | None = None,
    criterion: str | Criterion | None = None,
    preferred: ArrayLike | None = None,
    seed: int = 0,
    threads: int = 1,
) -> InverseResult:
    """Find joints that bring the tool to poses, for any arm; every pose is searched on its own.

    Parameters
    ----------
    T : (..., 4, 4), T_wt.
    q0 : (..., n) start of the first attempt, by default the middle of the limits. An arm that moves a little from one
        pose to the next is solved in two or three steps from its last joints.
    limits : whether the joints must stay within their limits. Joints without limits start within half a turn.
    tolerance : length of the pose error (m and rad) that counts as reached.
    restarts : attempts after the first, from a low-discrepancy sequence in the box of the limits.
    steps : most steps of one attempt.
    weights : (6,) of the error's rows, position then rotation vector; 0 leaves a row free: (1, 1, 1, 0, 0, 0) asks
        for the position only, (1, 1, 1, 1, 1, 0) in the tool frame leaves the turn about the tool's z axis free.
    weights_frame : "world" or "tool", required with `weights`.
    criterion : what a redundant arm prefers among its solutions: "limits" (far from them), "manipulability",
        "posture" (near `preferred`), or a function (model, q, preferred) -> number over traced scalars. It is climbed
        in the nullspace of the solution found, to a local maximum within the joint limits.
    preferred : (..., n) for the criterion; `q0`, or the middle of the limits, by default.
    seed : number of the first point of the sequence. The same call gives the same joints, whatever `threads` is.
    threads : threads that share a batch.

    Raises
    ------
    NotAPose, ShapeError, OutOfLimits, UnknownName, InputError
        `T` is no rigid transform; `q0` has another shape, NaN, or leaves the limits; no such criterion; ...

    Notes
    -----
    Damping proportional to the squared error: Chan & Lawrence, ICRA 1988; Sugihara, IEEE T-RO 27 (2011).
    """
    counted = None if weights is None else (np.shape(weights), tuple(np.ravel(weights).tolist()))
    solver: InverseSolver = arm.prepared[
        _solver, limits, tolerance, restarts, steps, counted, weights_frame, criterion, seed
    ]
    return solver(T, q0, preferred=preferred, threads=threads)


def _solver(
    arm: SolvedArm,
    limits: bool,
    tolerance: float,
    restarts: int,
    steps: int,
    weights: tuple[tuple[int, ...], tuple[float, ...]] | None,
    weights_frame: str | None,
    criterion: str | Criterion | None,
    seed: int,
) -> InverseSolver:
    """What `solve_inverse` keeps for an arm; weights: their shape and the numbers in a row."""
    return inverse_solver(
        arm,
        limits=limits,
        tolerance=tolerance,
        restarts=restarts,
        steps=steps,
        weights=None if weights is None else np.reshape(weights[1], weights[0]),
        weights_frame=weights_frame,
        criterion=criterion,
        seed=seed,
    )


_NONE = np.empty(0)
_STATUS = tuple(np.int8(status) for status in InverseStatus)


@dataclass(frozen=True, slots=True)
class InverseSolver:
    """A numerical inverse prepared for one arm and one way of searching: what `solve_inverse` calls, for many calls.

    `packed` holds chain and search for one pose at a time (see `loops.solver.solve_one`).
    """

    names: tuple[str, ...]
    limits: bool
    chain: Chain
    search: Search
    packed: tuple[Array, Array, NDArray[np.int64]]

    def __call__(
        self, T: ArrayLike, q0: ArrayLike | None = None, *, preferred: ArrayLike | None = None, threads: int = 1
    ) -> InverseResult:
        """Solve poses; arguments, result and errors as for `solve_inverse`."""
        if threads == 1 and (q0 is None or getattr(q0, "ndim", 0) == 1):
            found = self._one(T, q0, preferred)
            if found is not None:
                return found
        threads = check_threads(threads)
        goals, lead = _goals(T)
        starts = self._rows("q0", q0, lead)
        if self.limits and q0 is not None:
            self._check_limits(starts, lead)
        wanted = starts if preferred is None else self._rows("preferred", preferred, lead)
        if not wanted.shape[0] and self.search.criterion:
            middle = self.chain.origin + 0.5 * self.chain.span
            wanted = np.broadcast_to(middle, (goals.shape[0], middle.shape[0])).copy()
        q, status, residual, iterations = _run(self.chain, self.search, goals, starts, wanted, threads)
        return InverseResult(
            q.reshape(*lead, len(self.names)),
            status.reshape(lead)[()],
            residual.reshape(lead)[()],
            iterations.reshape(lead)[()],
        )

    def _one(self, T: Any, q0: Any, preferred: Any) -> InverseResult | None:
        """The result for one pose; None where it takes a second look to say what is wrong, or how arrays broadcast."""
        q, residual = np.empty(len(self.names)), np.empty(1)
        start = _NONE if q0 is None else q0
        wanted = start if preferred is None else preferred
        if wanted is _NONE and self.search.criterion:
            return None
        if not all(type(a) is np.ndarray and a.dtype == np.float64 and a.flags.carray for a in (T, start, wanted)):
            return None
        if T.ndim != 2 or wanted.ndim != 1:
            return None
        code = _solve_one()(*self.packed, self.limits, T, start, wanted, q, residual)
        if code < 0:
            return None
        return tuple.__new__(InverseResult, (q, _STATUS[code & 3], residual[0], np.int64(code >> 2)))

    def _rows(self, name: str, q: ArrayLike | None, lead: tuple[int, ...]) -> Array:
        """Joint vectors (N, n), one per pose; (0, n) if there are none."""
        n = len(self.names)
        if q is None:
            return np.empty((0, n))
        given = joint_vectors(name, q, self.names)
        try:
            return np.array(np.broadcast_to(given, (*lead, n))).reshape(-1, n)
        except ValueError:
            raise ShapeError(
                f"{name} must hold {n} joints per pose, of shape (..., {n}) that goes with the poses' {lead}; "
                f"shape {np.shape(q)} came"
            ) from None

    def _check_limits(self, rows: Array, lead: tuple[int, ...]) -> None:
        """Refuse a start outside the limits."""
        lower, upper = self.chain.lower, self.chain.upper
        beyond = outside(rows, lower, upper)
        if beyond.any():
            row, k = np.argwhere(beyond)[0]
            place = f" for pose {tuple(int(i) for i in np.unravel_index(row, lead))}" if lead else ""
            raise OutOfLimits(
                f"q0 has joint {self.names[k]!r} at {rows[row, k]:.6g}{place}; "
                f"its limits are {lower[k]:.6g} .. {upper[k]:.6g}. Start inside, or give limits=False"
            )


@functools.cache
def _solve_one() -> Callable[..., int]:
    from holonom.mechanics.loops.solver import solve_one  # compiled when it is first asked for

    return solve_one


def inverse_solver(
    arm: SolvedArm,
    *,
    limits: bool = True,
    tolerance: float = 1e-6,
    restarts: int = 200,
    steps: int = 30,
    weights: ArrayLike | None = None,
    weights_frame: str | None = None,
    criterion: str | Criterion | None = None,
    seed: int = 0,
) -> InverseSolver:
    """Prepare `solve_inverse` for repeated calls, for instance one pose per control period.

    Returns
    -------
    solver(T, q0=None, *, preferred=None, threads=1) -> InverseResult. Parameters and errors: see `solve_inverse`.
    """
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise InputError(f"tolerance is {tolerance}; a positive length of the pose error (m and rad) is needed")
    for name, value, least in (("restarts", restarts, 0), ("steps", steps, 1), ("seed", seed, 0)):
        _whole(name, value, least)
    attempts = int(restarts) + 1
    search = _search(arm, float(tolerance), attempts, int(steps), int(seed), weights, weights_frame, criterion)
    chain = _chain(arm, limits)
    whole = [search.task, search.multipliers, search.criterion, search.attempts, search.steps, search.first]
    packed = np.array(chain), np.array([search.tolerance, *search.weights]), np.array(whole, dtype=np.int64)
    return InverseSolver(arm.limits.names, bool(limits), chain, search, packed)


def _run(chain: Chain, search: Search, goals: Array, starts: Array, wanted: Array, threads: int) -> InverseResult:
    from holonom.mechanics.loops.solver import solve_rows

    count, n = goals.shape[0], chain.lower.shape[0]
    inputs = goals.reshape(-1), starts.reshape(-1), wanted.reshape(-1)
    q, residual = np.empty((count, n)), np.empty(count)
    status, iterations = np.empty(count, np.int8), np.empty(count, np.int64)

    size = max(LEAST_CHUNK, -(-count // (CHUNKS * threads))) if threads > 1 else max(count, 1)
    firsts = range(0, count, size)
    waiting = iter(firsts)

    def worker(_: int) -> None:
        for first in waiting:  # whoever is free takes the next chunk
            last = min(first + size, count)
            solve_rows(chain, search, *inputs, q.reshape(-1), status, residual, iterations, first, last)

    share(worker, min(threads, max(len(firsts), 1)))
    return InverseResult(q, status, residual, iterations)


def _whole(name: str, value: int, least: int) -> None:
    if int(value) != value or value < least:
        raise InputError(f"{name} is {value}; a whole number of at least {least} is needed")


def _goals(T: ArrayLike) -> tuple[Array, tuple[int, ...]]:
    """Rows of [R p] of the poses, (N, 12), and their leading axes."""
    poses = check_pose(T, "T")
    return np.ascontiguousarray(poses.reshape(-1, 16)[:, :12]), poses.shape[:-2]


def _chain(arm: SolvedArm, limits: bool) -> Chain:
    from holonom.mechanics.loops.solver import Chain

    bounds, n = arm.limits, arm.n
    for name, lower, upper in zip(bounds.names, bounds.lower, bounds.upper, strict=True):
        if not lower <= upper:
            raise ModelError(
                f"joint {name!r} has limits {lower} .. {upper}; the lower one must not exceed the upper one"
            )
    turning = [arm.model.joints[i].turns for i in arm.model.independent]
    low, high = _box(bounds.lower, bounds.upper, np.where(turning, math.pi, reach(arm.model)))
    free = np.full(n, np.inf)
    return Chain(
        bounds.lower if limits else -free,
        bounds.upper if limits else free,
        low,
        high - low,
        _strides(n),
        np.where(free_turns(arm.model), 2.0 * math.pi, 0.0),
        np.array(turning, dtype=float),
    )


def _box(lower: Array, upper: Array, scale: Array) -> tuple[Array, Array]:
    """Where restarts are drawn: limits up to `FAR` scales wide; of wider ones, or none, the two scales nearest to 0."""
    wide = ~(upper - lower <= FAR * scale)
    low = np.where(wide, np.maximum(lower, np.minimum(-scale, upper - 2.0 * scale)), lower)
    return low, np.where(wide, np.minimum(upper, low + 2.0 * scale), upper)


def free_turns(model: ArmModel) -> list[bool]:
    """Whether a whole turn of a joint changes nothing: it is revolute, and no other joint follows it; of each in q."""
    led = {joint.mimic.joint for joint in model.joints if joint.mimic is not None}
    return [model.joints[i].turns and i not in led for i in model.independent]


def _strides(n: int) -> Array:
    """Steps of the additive sequence: powers of 1 / x with x^(n + 1) = x + 1 (Roberts 2018)."""
    x = 2.0
    for _ in range(64):
        x = (1.0 + x) ** (1.0 / (n + 1))
    return x ** -np.arange(1.0, n + 1.0)


def _search(
    arm: SolvedArm,
    tolerance: float,
    attempts: int,
    steps: int,
    seed: int,
    weights: ArrayLike | None,
    frame: str | None,
    criterion: str | Criterion | None,
) -> Search:
    from holonom.mechanics.loops.solver import Search

    w, exact = _weights(weights, frame), weights is not None
    rows = np.concatenate([w[:3] / reach(arm.model), w[3:]])
    task, more = arm.pointer("pose_task", frame=frame or "world", exact=exact)
    rows = np.concatenate([rows, more])
    climbed = 0 if criterion is None else _criterion_address(arm, criterion)
    return Search(task, multipliers_kernel().address, climbed, rows, tolerance, attempts, steps, seed)


def _weights(weights: ArrayLike | None, frame: str | None) -> Array:
    if (weights is None) != (frame is None):
        raise InputError('weights= and weights_frame= ("world" or "tool") go together; one of them is missing')
    if weights is None:
        return np.ones(6)
    if frame not in ("world", "tool"):
        raise UnknownName("weights frame", str(frame), ("world", "tool"))
    w = real_array("weights", weights)
    if w.shape != (6,) or not np.isfinite(w).all() or w.min() < 0.0 or w.max() == 0.0:
        raise ShapeError(f"weights must be six numbers of at least 0, not all 0 (0: free); {weights} came")
    return w


def _criterion_address(arm: SolvedArm, criterion: str | Criterion) -> int:
    if isinstance(criterion, str) and criterion not in CRITERIA:
        raise UnknownName("criterion", criterion, CRITERIA)
    at_home = arm.first if isinstance(criterion, str) else arm  # those of the table do not ask where an arm stands
    return at_home.kernel("criterion", criterion=criterion).address
