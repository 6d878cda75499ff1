"""The tool along a course: joints on one branch of the inverse, one time law, slowed until every joint keeps up."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.errors import InputError, MotionError
from holonom.mechanics.arm.arm import IkStatus
from holonom.mechanics.motion.course import Course, where
from holonom.mechanics.motion.profile import GridSamples, on_grid, time_law
from holonom.mechanics.motion.trajectory import STILL, JointLimits, Trajectory, limits_of, standstill
from holonom.model.joint_values import written

__all__ = ["InverseSolutions", "LineArm", "ToolLimits", "plan_course"]


_SLOWEST = 50.0  # how many times slower than asked a line may become
_MARGIN = 1.002  # slowed a little more than computed, for the new samples lie elsewhere on the line
_PASSES = 8
_JUMP = 0.2  # joint motion between two samples (rad or m) that the Jacobian does not explain
_START = 1e-6  # largest difference (rad or m) between q0 and its own inverse
_ROUNDING = 1e-9  # by which a position (rad or m) may pass its limit
_NEWTON, _REACHED = 12, 1e-11  # steps, and the error (m, rad) at which they end
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


class ToolLimits(NamedTuple):
    """Largest speeds (m/s, rad/s) and accelerations (m/s^2, rad/s^2) of the tool, its place and its orientation."""

    speed: float
    rotation_speed: float
    acceleration: float
    rotation_acceleration: float


@dataclass(frozen=True, slots=True)
class _Geometry:
    """Joint positions `q` (N, n) on the line and their derivatives `slope` (N, n) by s."""

    q: Array
    slope: Array


def plan_course(
    arm: LineArm,
    start: Array,
    course: Course,
    tool: ToolLimits,
    bounds: JointLimits,
    dt: float,
    profile: str,
    line: int,
) -> Trajectory:
    """Move the tool along a course from `start` (n,), at rest at both ends; see `plan_line`."""
    way, angle = course.way, course.angle
    if way < STILL and angle < STILL:
        return standstill(start, dt, line)
    bend = max(course.bend / tool.acceleration, course.twist / tool.rotation_acceleration)
    top = min(_per(tool.speed, way), _per(tool.rotation_speed, angle), sqrt(_per(course.share, bend)))
    ramp = course.share * min(_per(tool.acceleration, way), _per(tool.rotation_acceleration, angle))
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
        f"{where(course, float(grid.law.s[row]))} joint {joint + 1} would have to be slowed {slow:.3g} "
        f"times (at most {_SLOWEST:g}): the arm is singular there or the speed too high; use a joint motion"
    )


def _inverse(arm: LineArm, start: Array, course: Course, s: Array) -> _Geometry:
    """Joints along the course: a branch of the closed form in one batch, or step by step where there is none."""
    try:
        q = _on_branch(arm, start, course, s)
    except InputError:
        q = _tracked(arm, start, course, s)
    slope = _solve(arm.jacobian(q, frame="world"), course.twists(s), course, s)
    unexplained = np.abs(np.diff(q, axis=0) - 0.5 * (slope[1:] + slope[:-1]) * np.diff(s)[:, None])
    if unexplained.max() > _JUMP:
        row, joint = np.unravel_index(int(np.argmax(unexplained)), unexplained.shape)
        raise MotionError(
            f"{where(course, float(s[row + 1]))} joint {joint + 1} would jump: the tool passes a singular "
            "pose; use a joint motion"
        )
    return _Geometry(q, slope)


def _on_branch(arm: LineArm, start: Array, course: Course, s: Array) -> Array:
    solutions = arm.ik(course.poses(s))
    branch = _branch(solutions, start)
    _check_status(solutions.status[:, branch], course, s)
    q: Array = np.unwrap(solutions.q[:, branch], axis=0)
    q += 2.0 * np.pi * np.round((start - q[0]) / (2.0 * np.pi))
    q[0] = start
    return q


def _tracked(arm: LineArm, start: Array, course: Course, s: Array) -> Array:
    """Newton's method from each pose to the next, by the least motion where there are joints to spare."""
    q = np.empty((s.shape[0], start.shape[0]))
    q[0] = start
    for k, T in enumerate(course.poses(s)[1:], 1):
        q[k] = q[k - 1]
        error = _pose_error(arm.fk(q[k]), T)
        for _ in range(_NEWTON):
            if np.abs(error).max() < _REACHED:
                break
            q[k] += np.linalg.pinv(arm.jacobian(q[k], frame="world"), rcond=1e-6) @ error
            error = _pose_error(arm.fk(q[k]), T)
        if not np.abs(error).max() < _REACHED:
            raise MotionError(
                f"{where(course, float(s[k]))} the pose is out of the arm's reach or the arm is singular; "
                "use a joint motion"
            )
    return q


def _pose_error(T: Array, goal: Array) -> Array:
    """Place and turn (6,) from one pose to another, in world axes."""
    R = goal[:3, :3] @ T[:3, :3].T
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.concatenate([goal[:3, 3] - T[:3, 3], turn])


def _check_status(status: NDArray[np.integer[Any]], course: Course, s: Array) -> None:
    """Refuse what cannot be reached; limits are checked later, on the turns that the joints really make."""
    for bad, words in (
        (IkStatus.UNREACHABLE, "the pose is out of the arm's reach; choose a nearer one"),
        (IkStatus.SINGULAR, "the arm is singular; use a joint motion"),
    ):
        if (status == bad).any():
            raise MotionError(f"{where(course, float(s[np.argmax(status == bad)]))} {words}")


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


def _solve(J: Array, twist: Array, course: Course, s: Array) -> Array:
    """Solve J u = twist (N, 6) for u (N, n); with fewer than six joints, the twist has to be in their reach."""
    n, Jt = J.shape[-1], np.swapaxes(J, -1, -2)
    try:
        if n == 6:
            return np.asarray(np.linalg.solve(J, twist[..., None])[..., 0], dtype=np.float64)
        if n > 6:
            return np.asarray((Jt @ np.linalg.solve(J @ Jt, twist[..., None]))[..., 0], dtype=np.float64)
        u = np.linalg.solve(Jt @ J, Jt @ twist[..., None])
    except np.linalg.LinAlgError as error:
        smallest = np.linalg.svd(J, compute_uv=False)[:, -1]
        at = float(s[np.argmin(smallest)])
        raise MotionError(f"{where(course, at)} the arm is singular; use a joint motion") from error
    missed = np.abs((J @ u)[..., 0] - twist).max(axis=-1)
    if missed.max() > _OFF * np.linalg.norm(twist, axis=-1).max():
        at = float(s[np.argmax(missed)])
        raise MotionError(f"{where(course, at)} the arm's {n} joints cannot follow the tool's motion")
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


def _check_positions(q: Array, limits: JointLimits, course: Course, s: Array) -> None:
    outside = (q < limits.lower - _ROUNDING) | (q > limits.upper + _ROUNDING)
    if outside.any():
        row = int(np.argmax(outside.any(axis=1)))
        j = int(np.argmax(outside[row]))
        raise MotionError(
            f"{where(course, float(s[row]))} {limits.names[j]} would go to "
            f"{written(q[row, j], limits.turns[j])}; {limits_of(limits, j)}"
        )


def _per(limit: float, distance: float) -> float:
    return limit / distance if distance > 0.0 else inf
