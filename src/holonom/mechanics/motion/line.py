"""Straight lines of the tool: position on the line, orientation by slerp, one time law for both."""

from __future__ import annotations

from numpy.typing import ArrayLike

from holonom.mechanics.motion.course import one_pose, straight
from holonom.mechanics.motion.tool import LineArm, ToolLimits, plan_course
from holonom.mechanics.motion.trajectory import JointLimits, Trajectory, joint_vector

__all__ = ["plan_line"]


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

    The tool point goes straight from its place at `q0` to that of `T1` while the orientation turns about one fixed axis
    by the shorter way (slerp); one time law drives both, set by the slower. The joints go on from `q0` by continuity,
    through a singular pose too where none has to jump. Where a joint would leave its speed or acceleration limit, the
    whole line is slowed.

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
        Part of the line is out of reach, outside a joint limit, or makes a joint jump; the message says where and
        why.
    NotAPose, ShapeError, OutOfLimits, UnknownName
        Bad arguments.
    """
    bounds = arm.limits if limits is None else limits
    start = joint_vector("q0", q0, bounds.lower.shape[0])
    course = straight(arm.fk(start), one_pose("the goal T1", T1))
    tool = ToolLimits(speed, rotation_speed, acceleration, rotation_acceleration)
    return plan_course(arm, start, course, tool, bounds, dt, profile, line)
