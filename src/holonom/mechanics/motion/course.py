"""Courses of the tool through the room: lines, arcs and splines, as poses over s from 0 to 1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import atan2, sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation, RotationSpline

from holonom.arrays import Array
from holonom.errors import MotionError, NotAPose, OutOfLimits, ShapeError
from holonom.mechanics.motion.joint_path import joint_spline
from holonom.mechanics.motion.trajectory import STILL
from holonom.spatial import check_pose

__all__ = ["Course", "arc_about", "arc_through", "one_pose", "spline_through", "straight", "where"]


_TURN_LENGTH = 0.25  # m per rad: how much a turn counts beside a way in the parameter of a spline
_DENSE = 2001  # values of s at which a spline's largest rates are looked for


@dataclass(frozen=True, slots=True)
class Course:
    """A way of the tool.

    Attributes
    ----------
    name
        For messages.
    poses, twists
        Functions of s (N,): T_wt (N, 4, 4), and its derivative by s [p'; w] (N, 6) in world axes.
    way, angle
        Largest |p'| (m) and |w| (rad) over s.
    bend, twist
        Largest |p''| (m) and |w'| (rad) over s.
    share
        Part of an acceleration limit that the ramp may take, so that it and the bends (as much again of the square of
        the speed) stay within the limit together.
    """

    name: str
    poses: Callable[[Array], Array]
    twists: Callable[[Array], Array]
    way: float
    angle: float
    bend: float = 0.0
    twist: float = 0.0
    share: float = 1.0


def where(course: Course, s: float) -> str:
    """Where on the course, for messages."""
    x, y, z = course.poses(np.array([s]))[0, :3, 3]
    return f"at {100 * s:.0f} % of the {course.name}, tool at ({x:.4f}, {y:.4f}, {z:.4f}) m,"


def one_pose(name: str, T: ArrayLike) -> Array:
    """`T` as one pose (4, 4)."""
    pose = check_pose(T, name)
    if pose.ndim != 2:
        raise NotAPose(f"{name} has shape {pose.shape}; give one pose (4, 4)")
    return pose


def straight(start: Array, goal: Array) -> Course:
    """A straight line, the orientation about one fixed axis by the shorter way (slerp)."""
    shift, turn = goal[:3, 3] - start[:3, 3], _turn(start, goal)

    def poses(s: Array) -> Array:
        return _stacked(_slerp(start, turn, s), start[:3, 3] + s[:, None] * shift)

    def twists(s: Array) -> Array:
        return np.broadcast_to(np.concatenate([shift, turn]), (s.shape[0], 6))

    return Course("straight line", poses, twists, _length(shift), _length(turn))


def arc_about(start: Array, center: Array, axis: Array, angle: float, turn: Array) -> Course:
    """An arc from `start` about an axis (3,) through `center` (3,); the tool turns by the vector `turn` (3,)."""
    size = _length(axis)
    if size < STILL:
        raise OutOfLimits(f"the axis of the circle is {axis}; give a direction")
    around = axis / size
    spoke = start[:3, 3] - center
    spoke = spoke - around * (around @ spoke)
    hub, radius = start[:3, 3] - spoke, _length(spoke)
    side = np.cross(around, spoke)

    def poses(s: Array) -> Array:
        c, si = np.cos(angle * s)[:, None], np.sin(angle * s)[:, None]
        return _stacked(_slerp(start, turn, s), hub + c * spoke + si * side)

    def twists(s: Array) -> Array:
        c, si = np.cos(angle * s)[:, None], np.sin(angle * s)[:, None]
        return np.concatenate([angle * (c * side - si * spoke), np.broadcast_to(turn, (s.shape[0], 3))], axis=1)

    way = abs(angle) * radius
    # ramp and bend stand at right angles: each may take sqrt(1/2) of the acceleration
    return Course("circle", poses, twists, way, _length(turn), bend=way * abs(angle), share=sqrt(0.5))


def arc_through(start: Array, via: Array, goal: Array) -> Course:
    """The circle through three places, from `start` past `via` (3,) to `goal`; orientation by slerp.

    Raises
    ------
    MotionError
        The places lie on a line or on one another.
    """
    a, b = via - start[:3, 3], goal[:3, 3] - start[:3, 3]
    normal = np.cross(a, b)
    if _length(normal) < 1e-9 * max(_length(a), _length(b)) ** 2 or _length(normal) < STILL:
        raise MotionError(
            f"no circle goes through {start[:3, 3]}, {via} and {goal[:3, 3]}: they lie on one line; use a straight line"
        )
    to_hub = np.cross(a @ a * b - b @ b * a, normal) / (2.0 * normal @ normal)
    center, around = start[:3, 3] + to_hub, normal / _length(normal)
    first, last = -to_hub, b - to_hub
    angle = atan2(float(around @ np.cross(first, last)), float(first @ last)) % (2.0 * np.pi)
    return arc_about(start, center, around, angle, _turn(start, goal))


def spline_through(poses: Array, degree: int) -> Course:
    """A spline through poses (k, 4, 4): places of degree 3 or 5; turning with continuous speed and acceleration.

    The orientation is SciPy's cubic `RotationSpline`.

    Raises
    ------
    ShapeError
        Neighbouring poses that are the same.
    """
    R, p = Rotation.from_matrix(poses[:, :3, :3]), poses[:, :3, 3]
    steps = np.linalg.norm(np.diff(p, axis=0), axis=1) + _TURN_LENGTH * (R[:-1].inv() * R[1:]).magnitude()
    if not (steps > STILL).all():
        k = int(np.argmin(steps))
        raise ShapeError(f"poses {k} and {k + 1} of the spline are the same; leave one out")
    s = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    place = joint_spline(p, degree=degree, s=s)
    turning = RotationSpline(s, R)
    at = np.linspace(0.0, 1.0, _DENSE)
    return Course(
        "spline",
        partial(_spline_poses, place, turning),
        partial(_spline_twists, place, turning),
        way=_largest(place(at, 1)),
        angle=_largest(turning(at, 1)),
        bend=_largest(place(at, 2)),
        twist=_largest(turning(at, 2)),
        share=0.5,
    )


def _spline_poses(place: Callable[[Array], Array], turning: RotationSpline, s: Array) -> Array:
    return _stacked(turning(s).as_matrix(), place(s))


def _spline_twists(place: Callable[[Array, int], Array], turning: RotationSpline, s: Array) -> Array:
    """SciPy gives turning speeds in the turning frame."""
    return np.concatenate([place(s, 1), turning(s).apply(turning(s, 1))], axis=1)


def _stacked(R: Array, p: Array) -> Array:
    T = np.zeros((p.shape[0], 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, p, 1.0
    return T


def _slerp(start: Array, turn: Array, s: Array) -> Array:
    R: Array = Rotation.from_rotvec(s[:, None] * turn).as_matrix() @ start[:3, :3]
    return R


def _turn(start: Array, goal: Array) -> Array:
    """Rotation vector in world axes that takes one orientation to the other."""
    turn: Array = (Rotation.from_matrix(goal[:3, :3]) * Rotation.from_matrix(start[:3, :3]).inv()).as_rotvec()
    return turn


def _length(v: Array) -> float:
    return float(np.linalg.norm(v))


def _largest(v: Array) -> float:
    return float(np.linalg.norm(v, axis=1).max())
