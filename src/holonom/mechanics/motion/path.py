"""Paths of several segments in one call, fly-by at the via points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array, real_array
from holonom.errors import NotAPose
from holonom.mechanics.motion.blend import blend as blended
from holonom.mechanics.motion.course import Course, arc_about, arc_through, one_pose, spline_through, straight
from holonom.mechanics.motion.tool import LineArm, ToolLimits, plan_course
from holonom.mechanics.motion.trajectory import JointLimits, Trajectory, joined, joint_vector, standstill
from holonom.spatial import check_pose

__all__ = ["ArcAbout", "ArcTo", "LineTo", "Segment", "SplineTo", "plan_path"]


class Segment(Protocol):
    """What a path is made of."""

    def course(self, start: Array) -> Course:
        """The way of the tool from a pose (4, 4)."""


@dataclass(frozen=True, slots=True)
class LineTo:
    """A straight line to a pose T_wt (4, 4), orientation by slerp."""

    goal: ArrayLike

    def course(self, start: Array) -> Course:
        """The way of the tool from a pose (4, 4)."""
        return straight(start, one_pose("the goal of a line", self.goal))


@dataclass(frozen=True, slots=True)
class ArcTo:
    """The arc past the point `via` (3,), or the place of a pose (4, 4), to the pose `goal`; orientation by slerp."""

    via: ArrayLike
    goal: ArrayLike

    def course(self, start: Array) -> Course:
        """The way of the tool from a pose (4, 4)."""
        via = real_array("the via point of an arc", self.via)
        place = via if via.shape == (3,) else one_pose("the via point of an arc", self.via)[:3, 3]
        return arc_through(
            start, finite_array("the via point of an arc", place, (3,)), one_pose("the goal of an arc", self.goal)
        )


@dataclass(frozen=True, slots=True)
class ArcAbout:
    """An arc of `angle` rad (any sign and size) about `axis` (3,) through `center` (3,), in the world.

    The tool turns with the arc, or keeps its orientation.
    """

    center: ArrayLike
    axis: ArrayLike
    angle: float
    turn_tool: bool = True

    def course(self, start: Array) -> Course:
        """The way of the tool from a pose (4, 4)."""
        center, axis = (
            finite_array("the center of an arc", self.center, (3,)),
            finite_array("the axis of an arc", self.axis, (3,)),
        )
        turn = self.angle * axis / max(float(np.linalg.norm(axis)), 1e-300) if self.turn_tool else np.zeros(3)
        return arc_about(start, center, axis, self.angle, turn)


@dataclass(frozen=True, slots=True)
class SplineTo:
    """A spline through poses (k, 4, 4), places of degree 3 or 5, turning speed and acceleration continuous."""

    poses: ArrayLike
    degree: int = 3

    def course(self, start: Array) -> Course:
        """The way of the tool from a pose (4, 4)."""
        poses = check_pose(self.poses, "the poses of a spline")
        if poses.ndim != 3:
            raise NotAPose(f"the poses of a spline have shape {poses.shape}; give (k, 4, 4)")
        return spline_through(np.concatenate([start[None], poses]), self.degree)


def plan_path(
    arm: LineArm,
    q0: ArrayLike,
    segments: Sequence[Segment | ArrayLike],
    *,
    speed: float,
    rotation_speed: float,
    acceleration: float,
    rotation_acceleration: float,
    blend: bool = True,
    limits: JointLimits | None = None,
    dt: float = 1e-3,
    profile: str = "scurve",
    line: int = 0,
) -> Trajectory:
    """Move the tool along lines, arcs and splines, at rest at both ends.

    Parameters
    ----------
    arm, q0, speed, rotation_speed, acceleration, rotation_acceleration, limits, dt, profile, line
        As in `plan_line`; the accelerations of the tool hold in bends too.
    segments
        `LineTo`, `ArcTo`, `ArcAbout`, `SplineTo`, in any order; a pose (4, 4) is a line to it.
    blend
        Fly by the places between segments (see `blend`; the tool cuts those corners), or stop at each.

    Returns
    -------
    Trajectory
        Off the blends the tool is on its course to rounding.

    Raises
    ------
    MotionError
        A segment that cannot be made: says which place of it, and why.
    NotAPose, ShapeError, OutOfLimits, UnknownName
        Bad arguments.
    """
    bounds = arm.limits if limits is None else limits
    whole = standstill(joint_vector("q0", q0, bounds.lower.shape[0]), dt, line)
    tool = ToolLimits(speed, rotation_speed, acceleration, rotation_acceleration)
    for segment in segments:
        course = _segment(segment).course(arm.fk(whole.end))
        part = plan_course(arm, whole.end, course, tool, bounds, dt, profile, line)
        whole = blended(whole, part, bounds) if blend else joined(whole, part, 0)
    return whole


def _segment(given: Segment | ArrayLike) -> Segment:
    return given if isinstance(given, LineTo | ArcTo | ArcAbout | SplineTo) else LineTo(given)  # type: ignore[arg-type]
