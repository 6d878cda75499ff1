"""The tool along a course: joints without a jump, one time law, slowed until every joint keeps up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, sqrt
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from holonom.arrays import Array
from holonom.errors import InputError, MotionError
from holonom.mechanics.arm.arm import IkStatus
from holonom.mechanics.motion.course import Course, where
from holonom.mechanics.motion.profile import Grid, grid_of, time_law
from holonom.mechanics.motion.trajectory import STILL, JointLimits, Trajectory, limits_of, standstill
from holonom.model.joint_values import written

__all__ = ["InverseSolutions", "LineArm", "ToolLimits", "plan_course"]


_SLOWEST = 50.0  # how many times slower than asked a line may become
_MARGIN = 1.002  # slowed a little more than computed, for the new samples lie elsewhere on the line
_PASSES = 8
_LONG = 20_000  # samples beyond which the joints are a cubic between as many knots
_TURN = 2.0 * np.pi
_SMALL = 0.1  # joint motion between two samples (rad or m) of one branch that needs no second look
_FREE = 1e-3  # distance (rad or m) from where the joints were going from which another member is looked for
_SMOOTH = 1e-5  # joint motion between two samples (rad or m) that least steps may leave unexplained
_SINGULAR = 1e-5  # least over greatest singular value of the Jacobian below which it tells no joint speeds
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

    def ik(self, T: Array, q0: Array) -> InverseSolutions:
        """All branches that reach T_wt (..., 4, 4); joints beside the way to the tool stay as in q0 (n,)."""


class ToolLimits(NamedTuple):
    """Largest speeds (m/s, rad/s) and accelerations (m/s^2, rad/s^2) of the tool, its place and its orientation."""

    speed: float
    rotation_speed: float
    acceleration: float
    rotation_acceleration: float


@dataclass(frozen=True, slots=True)
class _Geometry:
    """Joint positions `q` (N, n) on the line at `s` (N,), their derivatives `slope` (N, n) by s, and where q jumps."""

    s: Array
    q: Array
    slope: Array
    jump: tuple[int, int] | None


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
    slow, long = 1.0, None
    for _ in range(_PASSES):
        grid = grid_of(time_law(1.0, top / slow, ramp / slow**2, profile=profile), dt)
        if grid.count > _LONG and long is None:
            long = _knots(arm, start, course, bounds)
        if long is not None:
            trajectory, excess, s = _on_spline(long, grid, bounds, dt, line)
        else:
            s = grid.at(np.arange(grid.count)).s
            geometry = _inverse(arm, start, course, s)
            if geometry.jump is not None and slow < _SLOWEST:
                slow *= 4.0  # more samples: a joint that turns quickly is told from one that jumps
                continue
            _check_geometry(geometry, bounds, course)
            trajectory = _timed(geometry, grid, dt, line)
            excess = _excess(trajectory.qd, trajectory.qdd, bounds)
        worst = float(excess.max())
        if worst <= 1.0:
            return trajectory
        slow *= worst * _MARGIN
        if slow > _SLOWEST:
            break
    row, joint = np.unravel_index(int(np.argmax(excess)), excess.shape)
    more = f"at most {_SLOWEST:g}" if slow > _SLOWEST else f"and it would be {worst:.3g} times too fast even then"
    raise MotionError(
        f"{where(course, float(s[row]))} {bounds.names[joint]} would have to be slowed {slow:.3g} "
        f"times ({more}): the arm is singular there or the speed too high; use a joint motion"
    )


@dataclass(frozen=True, slots=True)
class _SplineRows:
    """Samples `offset`, ... of a law along joints `path` over s, a cubic between knots that lie close."""

    path: CubicHermiteSpline
    grid: Grid
    offset: int = 0

    @property
    def count(self) -> int:
        """How many there are."""
        return self.grid.count - self.offset

    def take(self, first: int, last: int) -> Array:
        """See `Rows`."""
        return self.at(np.arange(first + self.offset, min(last + self.offset, self.grid.count)))

    def at(self, samples: NDArray[np.number[Any]]) -> Array:
        """Positions, speeds, accelerations (3, k, n) at samples by their numbers in the law."""
        s, ds, dds = self.grid.at(samples)
        slope = self.path(s, 1)
        qdd = self.path(s, 2) * (ds * ds)[:, None] + slope * dds[:, None]
        return np.stack([self.path(s), slope * ds[:, None], qdd])

    def after(self, number: int) -> _SplineRows:
        """See `Rows`."""
        return replace(self, offset=self.offset + number)


def _knots(arm: LineArm, start: Array, course: Course, bounds: JointLimits) -> CubicHermiteSpline:
    """Joints over s of a motion with more samples than are looked at: a cubic between knots."""
    s = np.linspace(0.0, 1.0, _LONG + 1)
    geometry = _inverse(arm, start, course, s)
    _check_geometry(geometry, bounds, course)
    return CubicHermiteSpline(s, geometry.q, geometry.slope)


def _on_spline(
    path: CubicHermiteSpline, grid: Grid, bounds: JointLimits, dt: float, line: int
) -> tuple[Trajectory, Array, Array]:
    """The motion, how many times too fast its joints are at samples of each phase, and s there."""
    ends = (0.0, grid.ramp, grid.ramp + grid.cruise, grid.count - 1)
    looked_at = np.concatenate([np.linspace(a, b, _LONG // 4) for a, b in pairwise(ends)])
    rows = _SplineRows(path, grid)
    _, qd, qdd = rows.at(looked_at)
    return Trajectory.of(dt, rows, line, brake=grid.brake), _excess(qd, qdd, bounds), grid.at(looked_at).s


def _check_geometry(geometry: _Geometry, bounds: JointLimits, course: Course) -> None:
    """Refuse joints that jump or leave their limits."""
    if geometry.jump is not None:
        row, joint = geometry.jump
        raise MotionError(
            f"{where(course, float(geometry.s[row]))} {bounds.names[joint]} would jump: the tool passes a singular "
            "pose; use a joint motion"
        )
    _check_positions(geometry.q, bounds, course, geometry.s)


def _inverse(arm: LineArm, start: Array, course: Course, s: Array) -> _Geometry:
    """Joints along the course by continuity: of the closed form, or step by step where there is none."""
    try:
        q, singular = _followed(arm, start, course, s)
    except InputError:
        q, singular = _tracked(arm, start, course, s), np.zeros(len(s), dtype=bool)
    J = arm.jacobian(q, frame="world")
    if singular.any():
        # Where the Jacobian tells no joint speeds, the joints themselves do: they were followed without a jump. On a
        # way that stays singular they take the least steps, and so are their speeds.
        twists = course.twists(s)
        slope = np.gradient(q, s, axis=0)
        slope[~singular] = _solve(J[~singular], twists[~singular], course, s[~singular])
        stays = singular & np.roll(singular, 1) & np.roll(singular, -1)
        stays[[0, -1]] = singular[[0, -1]] & singular[[1, -2]]
        least = slope.copy()
        least[stays] = _least(J[stays], twists[stays])
        moved = np.abs(np.diff(q, axis=0) - 0.5 * (least[1:] + least[:-1]) * np.diff(s)[:, None]).max(axis=1)
        off = np.concatenate([moved[:1], np.maximum(moved[1:], moved[:-1]), moved[-1:]]) > _SMOOTH
        slope = np.where((stays & ~off)[:, None], least, slope)  # a joint that turns by itself is told as it is
    else:
        slope = _solve(J, course.twists(s), course, s)
    step = np.abs(np.diff(q, axis=0))
    unexplained = np.abs(np.diff(q, axis=0) - 0.5 * (slope[1:] + slope[:-1]) * np.diff(s)[:, None])
    told = singular[1:] | singular[:-1]
    jumps = np.where(told[:, None], step, unexplained)
    if jumps.max(initial=0.0) <= _JUMP:
        return _Geometry(s, q, slope, None)
    row, joint = np.unravel_index(int(np.argmax(jumps)), jumps.shape)
    return _Geometry(s, q, slope, (int(row) + 1, int(joint)))


def _followed(arm: LineArm, start: Array, course: Course, s: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Joints (N, n) of the closed form from `start` on, each the nearest to the one before, and where it is singular.

    A solution has a name, such as "righty flip", that may change on the way: where the wrist passes through its
    straight pose, no joint moves and flip becomes noflip. Whoever kept the name would see joints 4 and 6 jump by half
    a turn.
    """
    T = course.poses(s)
    solutions = arm.ik(T, start)
    branch = _branch(solutions, start, arm.limits.turns)
    if branch is not None and np.isin(solutions.status[:, branch], (IkStatus.OK, IkStatus.LIMIT)).all():
        q = np.unwrap(solutions.q[:, branch], axis=0)
        q += _TURN * np.round((start - q[0]) / _TURN)
        q[0] = start
        if np.abs(np.diff(q, axis=0)).max(initial=0.0) < _SMALL:
            return q, np.zeros(len(s), dtype=bool)
    return _nearest(arm, start, T, solutions, course, s)


def _nearest(
    arm: LineArm, start: Array, T: Array, solutions: InverseSolutions, course: Course, s: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """The solutions nearest to where the joints were going, sample by sample."""
    turning = np.array(arm.limits.turns)
    q = np.empty((len(s), len(start)))
    q[0] = start
    singular = True
    for k in range(1, len(s)):
        last = q[k - 1] - q[max(k - 2, 0)]
        ahead = q[k - 1] + last
        J = arm.jacobian(q[k - 1], frame="world")
        spread = np.linalg.svd(J, compute_uv=False)
        singular, before = spread[-1] < _SINGULAR * spread[0], singular
        if singular and before:  # a way that stays singular, by least steps
            ahead = q[k - 1] + _least(J, _pose_error(arm.fk(q[k - 1]), T[k]))
        ways = solutions.q[k, solutions.status[k] != IkStatus.UNREACHABLE]
        if not len(ways):
            raise MotionError(f"{where(course, float(s[k]))} the pose is out of the arm's reach; choose a nearer one")
        ways = ways + np.where(turning, _TURN * np.round((ahead - ways) / _TURN), 0.0)
        apart = np.abs(ways - ahead).max(axis=-1)
        q[k] = ways[np.argmin(apart)]
        if apart.min() > _FREE + np.abs(last).max():  # one of a set of solutions, or near one: another may be nearer
            settled = _settled(arm, ahead, T[k])
            if settled is not None and np.abs(settled - ahead).max() < apart.min():
                q[k] = settled
    spread = np.linalg.svd(arm.jacobian(q, frame="world"), compute_uv=False)
    return q, spread[:, -1] < _SINGULAR * spread[:, 0]


def _least(J: Array, twist: Array) -> Array:
    """Joint speeds (..., n) of least norm that make of a twist (..., 6) what a singular arm can make of it."""
    return np.asarray((np.linalg.pinv(J, rcond=_SINGULAR) @ twist[..., None])[..., 0])


def _settled(arm: LineArm, q: Array, T: Array) -> Array | None:
    """The joints nearest to q that bring the tool to T by Newton's method in least steps; None where it fails."""
    error = _pose_error(arm.fk(q), T)
    for _ in range(_NEWTON):
        if np.abs(error).max() < _REACHED:
            return q
        q = q + np.linalg.pinv(arm.jacobian(q, frame="world"), rcond=1e-6) @ error
        error = _pose_error(arm.fk(q), T)
    return q if np.abs(error).max() < _REACHED else None


def _tracked(arm: LineArm, start: Array, course: Course, s: Array) -> Array:
    """Newton's method from each pose to the next, by the least motion where there are joints to spare."""
    q = np.empty((s.shape[0], start.shape[0]))
    q[0] = start
    for k, T in enumerate(course.poses(s)[1:], 1):
        settled = _settled(arm, q[k - 1], T)
        if settled is None:
            raise MotionError(
                f"{where(course, float(s[k]))} the pose is out of the arm's reach or the arm is singular; "
                "use a joint motion"
            )
        q[k] = settled
    return q


def _pose_error(T: Array, goal: Array) -> Array:
    """Place and turn (6,) from one pose to another, in world axes."""
    R = goal[:3, :3] @ T[:3, :3].T
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return np.concatenate([goal[:3, 3] - T[:3, 3], turn])


def _branch(solutions: InverseSolutions, start: Array, turns: Sequence[bool]) -> int | None:
    """Index of the branch that `start` lies on, from the solutions for its own pose; None where it lies on none."""
    difference = solutions.q[0] - start
    difference -= np.where(turns, _TURN * np.round(difference / _TURN), 0.0)
    distance = np.abs(difference).max(axis=-1)
    branch = int(np.argmin(distance))
    return branch if distance[branch] <= _START else None


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


def _timed(geometry: _Geometry, grid: Grid, dt: float, line: int) -> Trajectory:
    _, ds, dds = grid.at(np.arange(grid.count))
    drift = np.gradient(geometry.slope, dt, axis=0)
    qd = geometry.slope * ds[:, None]
    qdd = drift * ds[:, None] + geometry.slope * dds[:, None]
    return Trajectory(dt, geometry.q, qd, qdd, line, brake=grid.brake)


def _excess(qd: Array, qdd: Array, limits: JointLimits) -> Array:
    """How many times too fast each joint is at each sample (N, n), in terms of the line's duration."""
    return np.maximum(np.abs(qd) / limits.speed, np.sqrt(np.abs(qdd) / limits.acceleration))


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
