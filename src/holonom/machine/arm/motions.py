"""From what a program asks to a trajectory: which branch, which limits, how fast; errors in the program's terms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Protocol

import numpy as np

from holonom.arrays import Array
from holonom.errors import InputError, MotionError
from holonom.machine.arm.clock import TICK
from holonom.mechanics import Arm, IkStatus
from holonom.mechanics.arm.members import Reference, nearest_members
from holonom.mechanics.motion import Trajectory, plan_joint, plan_line
from holonom.mechanics.motion.trajectory import check_inside, joint_vector
from holonom.model.joint_values import in_degrees, range_in_degrees

__all__ = ["LineSettings", "MotionRequest", "branch_joints", "plan"]


_FREE = (IkStatus.SINGULAR, IkStatus.SINGULAR_LIMIT)
"""Status of branches that are one of infinitely many solutions."""
_ON_BRANCH = 1e-4
"""Distance (rad or m) from a branch within which joints lie on it."""


class MotionRequest(Protocol):
    """What a machine reads of a `lang.Motion`; see there."""

    @property
    def kind(self) -> str:
        """Whether "joint" or "line"."""

    @property
    def pose(self) -> Array | None:
        """Goal T_wt (4, 4), if it is a pose."""

    @property
    def joints(self) -> Array | None:
        """Goal joints (n,) rad, if it is a precision point."""

    @property
    def speed(self) -> float:
        """Fraction of full speed."""

    @property
    def speed_mps(self) -> float | None:
        """Tool speed instead, m/s."""

    @property
    def acceleration(self) -> float:
        """Fraction of full acceleration."""

    @property
    def configuration(self) -> Any:
        """Named branch, see `lang.Configuration`."""

    @property
    def blend(self) -> bool:
        """Whether the next motion may overlap its end."""

    @property
    def tolerance(self) -> str:
        """How closely to settle, "coarse" or "fine"."""

    @property
    def line(self) -> int:
        """Source line."""

    def to(self, pose: Array) -> MotionRequest:
        """Return the same motion to another pose (4, 4)."""


@dataclass(frozen=True, slots=True)
class LineSettings:
    """Nominal straight-line motion: m/s, m/s2, rad/s, rad/s2."""

    speed: float = 0.5
    acceleration: float = 2.0
    rotation_speed: float = 2.0
    rotation_acceleration: float = 8.0


def branch_joints(arm: Arm, T: Array, q0: Array, configuration: Any) -> Array:
    """Joints (n,) that bring the tool to T_wt: the branch nearest to q0, or nearest of those named.

    Raises
    ------
    MotionError
        No reachable branch inside the joint limits; says whether reach or which limit is the cause.
    """
    wanted = _wanted(configuration)
    if not wanted:
        nearest = arm.ik_nearest(T, q0)
        if nearest.status in (IkStatus.OK, IkStatus.SINGULAR, IkStatus.FAR):
            return nearest.q
    if arm.closed_form is None:
        raise MotionError(_not_found(T, wanted))
    found = arm.ik(T, q0)
    fits = np.array([all(w in name.split() for w in wanted) for name in found.names])
    q = _nearest_of(arm, T, q0, found.q[fits], found.status[fits])
    if q is None:
        raise MotionError(_why(arm, T, found.q[fits], found.status[fits], wanted))
    return q


def _nearest_of(arm: Arm, T: Array, q0: Array, q: Array, status: Array) -> Array | None:
    """The nearest to q0 of branches (k, n), each by its nearest member within the limits; None where none has one."""
    limits = arm.limits
    turns = np.where(limits.turns, 2.0 * np.pi, 0.0)
    to = Reference(q0[None], limits.lower, limits.upper, turns, np.ones(arm.n))
    reached = status != IkStatus.UNREACHABLE
    q, free = to.turned(q[reached]), np.isin(status[reached], _FREE)
    if free.any():
        owner = np.zeros(int(free.sum()), dtype=np.intp)
        q[free], _ = nearest_members(arm, T[None], q[free], owner, to)
    q = q[to.violation(q) == 0.0]
    return q[np.argmin(to.distance(q))] if len(q) else None


def _not_found(T: Array, wanted: Sequence[str]) -> str:
    """Why an arm without a closed form does not go there."""
    if wanted:
        return f"{' '.join(wanted).upper()} was asked for; this arm has no configurations with names: leave it out"
    place = ", ".join(f"{1e3 * v:.1f}" for v in T[:3, 3])
    return (
        f"the tool cannot reach ({place}) mm: no joints within the limits were found that bring it there; move the "
        "location nearer to the arm, or turn it"
    )


def _wanted(configuration: Any) -> list[str]:
    return [w for w in (configuration.shoulder, configuration.elbow, configuration.wrist) if w is not None]


def _check_kept(arm: Arm, ends: Sequence[Array], wanted: Sequence[str]) -> None:
    """Refuse a line that begins or ends in another configuration than the program asked for."""
    for q, verb in zip(ends, ("is", "would end"), strict=False):
        name = _branch_of(arm, q) if arm.closed_form is not None else "without configurations"
        others = [w for w in wanted if name is not None and w not in name.split()]
        if others:
            raise MotionError(
                f"a straight line cannot change the configuration: {' '.join(others).upper()} was asked for, "
                f"and the arm {verb} {name}; MOVE there first, or ask for what it is"
            )


def _branch_of(arm: Arm, q: Array) -> str | None:
    """The name of the branch that joints (n,) lie on; None where they lie on none, as in a singular pose."""
    found = arm.ik(arm.fk(q), q)
    apart = found.q - q
    apart -= np.where(arm.limits.turns, 2.0 * np.pi * np.round(apart / (2.0 * np.pi)), 0.0)
    distance = np.where(np.isin(found.status, _FREE), np.inf, np.abs(apart).max(-1))
    k = int(np.argmin(distance))
    return found.names[k] if distance[k] < _ON_BRANCH else None


def _why(arm: Arm, T: Array, q: Array, status: Array, wanted: Sequence[str]) -> str:
    place = ", ".join(f"{1e3 * v:.1f}" for v in T[:3, 3])
    named = f" as {' '.join(wanted)}" if wanted else ""
    if (status == IkStatus.UNREACHABLE).all():
        return f"the tool cannot reach ({place}) mm{named}: out of reach of the arm; move the location nearer to it"
    limits = arm.limits
    inside = q[status != IkStatus.UNREACHABLE]
    excess = np.maximum(limits.lower - inside, inside - limits.upper).clip(0.0)
    best = inside[np.argmin(excess.max(-1))]
    j = int(np.argmax(np.maximum(limits.lower - best, best - limits.upper)))
    turns = limits.turns[j]
    return (
        f"the tool can reach ({place}) mm{named} only outside a joint limit: {limits.names[j]} would be at "
        f"{in_degrees(best[j], turns)}; its limits are "
        f"{range_in_degrees(limits.lower[j], limits.upper[j], turns)}"
    )


def plan(
    arm: Arm, q0: Array, motion: MotionRequest, settings: LineSettings, dt: float = TICK, *, longest: float = inf
) -> Trajectory:
    """Return the trajectory of one motion from rest at q0 (n,), with a sample every `dt`, s.

    Raises
    ------
    MotionError
        The motion cannot be made, or takes more than `longest`, s.
    """
    try:
        if motion.kind == "line":
            trajectory = _plan_line(arm, q0, motion, settings, dt)
        else:
            trajectory = _plan_joint(arm, q0, motion, dt)
    except InputError as problem:  # a program asked for it, after the start
        raise MotionError(str(problem)) from problem
    if trajectory.duration > longest:
        raise MotionError(
            f"the motion would take {trajectory.duration:.6g} s; up to {longest:g} s are allowed, "
            "the cell's time_limit: ask for more speed or acceleration, or raise it"
        )
    return trajectory


def _plan_line(arm: Arm, q0: Array, motion: MotionRequest, settings: LineSettings, dt: float) -> Trajectory:
    """A straight line; an absolute speed above the nominal one turns the tool no faster than the settings allow."""
    target = motion.pose
    if target is None:
        assert motion.joints is not None
        target = arm.fk(motion.joints)
    speed = motion.speed_mps if motion.speed_mps is not None else motion.speed * settings.speed
    wanted = _wanted(motion.configuration)
    if wanted:
        _check_kept(arm, [q0], wanted)
    trajectory = plan_line(
        arm,
        q0,
        target,
        speed=speed,
        rotation_speed=settings.rotation_speed * min(1.0, max(motion.speed, speed / settings.speed)),
        acceleration=motion.acceleration * settings.acceleration,
        rotation_acceleration=motion.acceleration * settings.rotation_acceleration,
        dt=dt,
        line=motion.line,
    )
    if wanted:
        _check_kept(arm, [q0, trajectory.end], wanted)
    return trajectory


def _plan_joint(arm: Arm, q0: Array, motion: MotionRequest, dt: float) -> Trajectory:
    q1 = motion.joints
    if q1 is None:
        assert motion.pose is not None
        q1 = branch_joints(arm, motion.pose, q0, motion.configuration)
    check_inside(joint_vector("q1", q1, arm.n), arm.limits, in_degrees=True)
    return plan_joint(q0, q1, arm.limits, speed=motion.speed, acceleration=motion.acceleration, dt=dt, line=motion.line)
