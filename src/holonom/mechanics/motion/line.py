"""Straight lines of the tool: position on the line, orientation by slerp, one time law for both."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from holonom.errors import MotionError, NotAPose
from holonom.mechanics.arm import IkStatus
from holonom.mechanics.motion.profile import GridSamples, on_grid, time_law
from holonom.mechanics.motion.trajectory import STILL, JointLimits, Trajectory, joint_vector, standstill
from holonom.spatial import check_pose

__all__ = ["InverseSolutions", "LineArm", "plan_line"]

Array = NDArray[np.float64]

_SLOWEST = 50.0  # how many times slower than asked a line may become
_MARGIN = 1.002  # slowed a little more than computed, for the new samples lie elsewhere on the line
_PASSES = 8
_JUMP = 0.2  # joint motion between two samples (rad or m) that the Jacobian does not explain
_START = 1e-6  # largest difference (rad or m) between q0 and its own inverse
_ROUNDING = 1e-9  # by which a position (rad or m) may pass its limit
_OFF = 1e-6  # part of the tool's motion that an arm with fewer than six joints may miss


class InverseSolutions(Protocol):
    """Inverse geometry of poses: k branches each, in the same order for all poses."""

    @property
    def q(self) -> Array:
        """Joint positions (..., k, n)."""

    @property
    def status(self) -> NDArray[np.integer[Any]]:
        """What became of each branch, an `IkStatus` (..., k)."""


class LineArm(Protocol):
    """What a line needs of an arm."""

    @property
    def limits(self) -> JointLimits:
        """Joint limits."""

    def fk(self, q: Array) -> Array:
        """Tool poses T_wt (..., 4, 4) of q (..., n)."""

    def jacobian(self, q: Array, *, frame: Literal["world"]) -> Array:
        """Jacobians (..., 6, n), [v; w] of the tool point in world axes, of q (..., n)."""

    def ik(self, T: Array) -> InverseSolutions:
        """All branches that reach T_wt (..., 4, 4)."""


@dataclass(frozen=True, slots=True)
class _Course:
    """Motion of the tool in world axes from `start` (4, 4) by `shift` (m) and `turn` (rotation vector)."""

    start: Array
    shift: Array
    turn: Array


@dataclass(frozen=True, slots=True)
class _Geometry:
    """Joint positions `q` (N, n) on the line and their derivatives `slope` (N, n) by s."""

    q: Array
    slope: Array


def plan_line(
    arm: LineArm,
    q0: ArrayLike,
    T1: ArrayLike,
    *,
    speed: float,
    rotation_speed: float,
    acceleration: float,
    rotation_acceleration: float,
    limits: JointLimits | None = None,
    dt: float = 1e-3,
    profile: str = "scurve",
    line: int = 0,
) -> Trajectory:
    """Move the tool on a straight line, at rest at both ends.

    The tool point goes straight from its place at `q0` to that of `T1` while the orientation turns about one
    fixed axis by the shorter way (slerp); one time law drives both, set by the slower. The joints stay on the
    inverse branch of `q0`. Where a joint would leave its speed or acceleration limit, the whole line is
    slowed.

    Parameters
    ----------
    arm
        Forward and inverse geometry, world Jacobian, limits.
    q0
        Start (n,), rad or m.
    T1
        Goal of the tool, T_wt (4, 4).
    speed, acceleration
        Largest values of the tool point, m/s and m/s^2.
    rotation_speed, rotation_acceleration
        Largest values of the orientation, rad/s and rad/s^2.
    limits
        Joint limits; `arm.limits` if not given.
    dt
        Time between samples (s).
    profile
        A name in `PROFILES`.
    line
        Source line to carry along.

    Returns
    -------
    Trajectory
        Speeds solve J qd = [v; w] exactly; accelerations differentiate J^-1 along the line by central
        differences, with an error of order dt^2. The first sample is `q0`, exactly.

    Raises
    ------
    MotionError
        Part of the line is out of reach, outside a joint limit or singular, or the branch breaks off; the
        message says where and why.
    NotAPose, ShapeError, OutOfLimits, UnknownName
        Bad arguments.
    """
    bounds = arm.limits if limits is None else limits
    start = joint_vector("q0", q0, bounds.lower.shape[0])
    goal = check_pose(T1, "the goal T1")
    if goal.ndim != 2:
        raise NotAPose(f"the goal T1 has shape {goal.shape}; give one pose (4, 4)")
    course = _course(arm.fk(start), goal)
    way, angle = float(np.linalg.norm(course.shift)), float(np.linalg.norm(course.turn))
    if way < STILL and angle < STILL:
        return standstill(start, dt, line)
    top = min(_per(speed, way), _per(rotation_speed, angle))
    ramp = min(_per(acceleration, way), _per(rotation_acceleration, angle))
    slow = 1.0
    for _ in range(_PASSES):
        grid = on_grid(time_law(1.0, top / slow, ramp / slow**2, profile=profile), dt)
        geometry = _inverse(arm, start, course, grid.law.s)
        _check_positions(geometry.q, bounds, course, grid.law.s)
        trajectory = _timed(geometry, grid, dt, line)
        excess = _excess(trajectory, bounds)
        worst = float(excess.max())
        if worst <= 1.0:
            return trajectory
        slow *= worst * _MARGIN
        if slow > _SLOWEST:
            break
    row, joint = np.unravel_index(int(np.argmax(excess)), excess.shape)
    raise MotionError(
        f"{_where(course, float(grid.law.s[row]))} joint {joint + 1} would have to be slowed {slow:.3g} "
        f"times (at most {_SLOWEST:g}): the arm is singular there or the speed too high; use a joint motion"
    )


def _course(start: Array, goal: Array) -> _Course:
    turn = Rotation.from_matrix(goal[:3, :3]) * Rotation.from_matrix(start[:3, :3]).inv()
    return _Course(start, goal[:3, 3] - start[:3, 3], turn.as_rotvec())


def _poses(course: _Course, s: Array) -> Array:
    """Tool poses (N, 4, 4) at fractions s (N,) of the line."""
    T = np.zeros((s.shape[0], 4, 4))
    T[:, :3, :3] = Rotation.from_rotvec(s[:, None] * course.turn).as_matrix() @ course.start[:3, :3]
    T[:, :3, 3] = course.start[:3, 3] + s[:, None] * course.shift
    T[:, 3, 3] = 1.0
    return T


def _inverse(arm: LineArm, start: Array, course: _Course, s: Array) -> _Geometry:
    """Joints along the line on the branch of `start`, in one batch."""
    solutions = arm.ik(_poses(course, s))
    branch = _branch(solutions, start)
    _check_status(solutions.status[:, branch], course, s)
    q = np.unwrap(solutions.q[:, branch], axis=0)
    q += 2.0 * np.pi * np.round((start - q[0]) / (2.0 * np.pi))
    q[0] = start
    twist = np.concatenate([course.shift, course.turn])
    slope = _solve(arm.jacobian(q, frame="world"), twist, course, s)
    unexplained = np.abs(np.diff(q, axis=0) - 0.5 * (slope[1:] + slope[:-1]) * np.diff(s)[:, None])
    if unexplained.max() > _JUMP:
        row, joint = np.unravel_index(int(np.argmax(unexplained)), unexplained.shape)
        raise MotionError(
            f"{_where(course, float(s[row + 1]))} joint {joint + 1} would jump: the line passes a singular "
            "pose; use a joint motion"
        )
    return _Geometry(q, slope)


def _check_status(status: NDArray[np.integer[Any]], course: _Course, s: Array) -> None:
    """Refuse what cannot be reached; limits are checked later, on the turns that the joints really make."""
    for bad, words in (
        (IkStatus.UNREACHABLE, "the pose is out of the arm's reach; choose a nearer one"),
        (IkStatus.SINGULAR, "the arm is singular; use a joint motion"),
    ):
        if (status == bad).any():
            raise MotionError(f"{_where(course, float(s[np.argmax(status == bad)]))} {words}")


def _branch(solutions: InverseSolutions, start: Array) -> int:
    """Index of the branch that `start` lies on, from the solutions for its own pose."""
    difference = (solutions.q[0] - start + np.pi) % (2.0 * np.pi) - np.pi
    distance = np.abs(difference).max(axis=-1)
    branch = int(np.argmin(distance))
    if not distance[branch] <= _START:
        raise MotionError(
            f"no branch of the inverse comes back to the start q0 = {np.array2string(start, precision=4)} "
            f"(nearest: {distance[branch]:.3g} away): it is singular or out of reach; "
            "leave it by a joint motion"
        )
    return branch


def _solve(J: Array, twist: Array, course: _Course, s: Array) -> Array:
    """Solve J u = twist (6,) for u (N, n); with fewer than six joints, the twist has to be in their reach."""
    try:
        if J.shape[-1] == 6:
            return np.asarray(np.linalg.solve(J, twist[:, None])[..., 0], dtype=np.float64)
        Jt = np.swapaxes(J, -1, -2)
        u = np.linalg.solve(Jt @ J, (Jt @ twist)[..., None])
    except np.linalg.LinAlgError as error:
        smallest = np.linalg.svd(J, compute_uv=False)[:, -1]
        at = float(s[np.argmin(smallest)])
        raise MotionError(f"{_where(course, at)} the arm is singular; use a joint motion") from error
    missed = np.abs((J @ u)[..., 0] - twist).max(axis=-1)
    if missed.max() > _OFF * np.linalg.norm(twist):
        at = float(s[np.argmax(missed)])
        raise MotionError(f"{_where(course, at)} the arm's {J.shape[-1]} joints cannot follow the tool's motion")
    return np.asarray(u[..., 0], dtype=np.float64)


def _timed(geometry: _Geometry, grid: GridSamples, dt: float, line: int) -> Trajectory:
    _, ds, dds = grid.law
    drift = np.gradient(geometry.slope, dt, axis=0)
    qd = geometry.slope * ds[:, None]
    qdd = drift * ds[:, None] + geometry.slope * dds[:, None]
    return Trajectory(dt, geometry.q, qd, qdd, line, brake=grid.brake)


def _excess(trajectory: Trajectory, limits: JointLimits) -> Array:
    """How many times too fast each joint is at each sample (N, n), in terms of the line's duration."""
    speed = np.abs(trajectory.qd) / limits.speed
    return np.maximum(speed, np.sqrt(np.abs(trajectory.qdd) / limits.acceleration))


def _check_positions(q: Array, limits: JointLimits, course: _Course, s: Array) -> None:
    outside = (q < limits.lower - _ROUNDING) | (q > limits.upper + _ROUNDING)
    if outside.any():
        row = int(np.argmax(outside.any(axis=1)))
        j = int(np.argmax(outside[row]))
        raise MotionError(
            f"{_where(course, float(s[row]))} joint {j + 1} would go to {q[row, j]:.6g}; "
            f"its limits are {limits.lower[j]:.6g} to {limits.upper[j]:.6g} (rad or m)"
        )


def _where(course: _Course, s: float) -> str:
    x, y, z = course.start[:3, 3] + s * course.shift
    return f"at {100 * s:.0f} % of the straight line, tool at ({x:.4f}, {y:.4f}, {z:.4f}) m,"


def _per(limit: float, distance: float) -> float:
    return limit / distance if distance > 0.0 else inf
