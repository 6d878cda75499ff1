"""Which message has which layout, for writing and, from a first message, for reading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holonom.app.recording.format.cdr import CdrReader, CdrWriter, Layout
from holonom.app.recording.format.kernels import fill_pose_rows
from holonom.arrays import Array
from holonom.signals import Event, Marker, Photograph

__all__ = [
    "LEVELS",
    "WORLD",
    "JointMessage",
    "array_layout",
    "array_size",
    "image_message",
    "inertial_layout",
    "inertial_plane",
    "inertial_values",
    "joint_layout",
    "joint_message",
    "log_event",
    "log_message",
    "marker_message",
    "odometry_frames",
    "odometry_layout",
    "odometry_plane",
    "odometry_values",
    "pose_layout",
    "pose_rows",
    "stamped_frame",
    "transform_frames",
    "transform_layout",
]


WORLD, ODOM, BASE = "world", "odom", "base_link"
_PLANE = np.array([0, 1, 5])
"""x, y and turning about z among the six of a ROS pose or twist."""
_COVARIANCE, _TWIST = (7 + 6 * _PLANE[:, None] + _PLANE).ravel(), 43 + _PLANE
"""Their places among the numbers of a nav_msgs/Odometry."""
MARKERS = {"cube": 1, "cylinder": 3}
"""Types of visualization_msgs/Marker."""
LEVELS = {"debug": 10, "info": 20, "warning": 30, "error": 40}


class JointMessage(NamedTuple):
    """What fixes the layout of a JointState: names, how many of the three arrays are filled, and the header's frame.

    Other tools leave out an array in between: `sizes` then says how many numbers each of the three holds.
    """

    names: tuple[str, ...]
    arrays: int
    frame: str = ""
    sizes: tuple[int, ...] = ()

    def filled(self) -> tuple[int, ...]:
        """How many numbers each of the three arrays holds."""
        n = len(self.names)
        return self.sizes or tuple(n if array < self.arrays else 0 for array in range(3))


def joint_layout(kind: JointMessage) -> Layout:
    """sensor_msgs/JointState; open: position, velocity, effort, those of them that are filled."""
    out = CdrWriter().stamp().text(kind.frame).uint32(len(kind.names))
    for name in kind.names:
        out.text(name)
    for count in kind.filled():
        out.uint32(count).doubles(count)
    return out.layout()


def joint_message(message: bytes) -> JointMessage:
    """Names and filled arrays of a sensor_msgs/JointState."""
    data = CdrReader(message)
    data.stamp()
    frame = data.text()
    names = tuple(data.text() for _ in range(data.uint32()))
    sizes = []
    for _ in range(3):
        sizes.append(data.uint32())
        data.skip_doubles(sizes[-1])
    usual = JointMessage(names, sum(size > 0 for size in sizes), frame)
    return usual if list(usual.filled()) == sizes else usual._replace(sizes=tuple(sizes))


def array_layout(count: int) -> Layout:
    """std_msgs/Float64MultiArray or Int64MultiArray of one dimension, the axes; open: the numbers."""
    out = CdrWriter().uint32(1).text("axis").uint32(count).uint32(count).uint32(0)
    return out.uint32(count).doubles(count).layout()


def array_size(message: bytes) -> int:
    """How many numbers a message of `array_layout` holds."""
    data = CdrReader(message)
    data.uint32()
    data.text()
    size = data.uint32()
    if 8 * size > len(message):
        raise ValueError(f"it has {len(message)} bytes and says that it holds {size} numbers")
    return size


def transform_layout(frames: Sequence[tuple[str, str]]) -> Layout:
    """tf2_msgs/TFMessage of (parent, child)s; open: x y z and quaternion x y z w of each."""
    out = CdrWriter().uint32(len(frames))
    for parent, child in frames:
        out.stamp().text(parent).text(child).doubles(7)
    return out.layout()


def transform_frames(message: bytes) -> tuple[tuple[str, str], ...]:
    """(Parent, child)s of a tf2_msgs/TFMessage."""
    data = CdrReader(message)
    frames = []
    for _ in range(data.uint32()):
        data.stamp()
        frames.append((data.text(), data.text()))
        data.skip_doubles(7)
    return tuple(frames)


def pose_layout(frame: str = WORLD) -> Layout:
    """geometry_msgs/PoseStamped in a frame; open: x y z and quaternion x y z w."""
    return CdrWriter().stamp().text(frame).doubles(7).layout()


def pose_rows(poses: Array) -> Array:
    """Rows (k, 7), x y z and quaternion x y z w, of poses (k, 4, 4)."""
    rows = np.empty((len(poses), 7))
    fill_pose_rows(np.ascontiguousarray(poses, dtype=np.float64), rows)
    return rows


def odometry_layout(frames: tuple[str, str] = (ODOM, BASE)) -> Layout:
    """nav_msgs/Odometry of the second frame in the first; open: the numbers of `odometry_values`."""
    return CdrWriter().stamp().text(frames[0]).text(frames[1]).doubles(7 + 36 + 6 + 36).layout()


def odometry_frames(message: bytes) -> tuple[str, str]:
    """Frames of a nav_msgs/Odometry."""
    data = CdrReader(message)
    data.stamp()
    return data.text(), data.text()


def odometry_values(pose: Array, twist: Array, covariance: Array) -> Array:
    """Pose (3,) and its covariance (3, 3), twist (3,) of a plane base as the 85 numbers of a nav_msgs/Odometry."""
    values = np.zeros(85)
    values[[0, 1, 5, 6]] = pose[0], pose[1], math.sin(pose[2] / 2), math.cos(pose[2] / 2)
    values[_COVARIANCE] = covariance.ravel()
    values[_TWIST] = twist
    return values


def odometry_plane(values: Array) -> tuple[Array, Array, Array]:
    """Poses (N, 3), twists (N, 3) and covariances (N, 3, 3) from rows (N, 85) of nav_msgs/Odometry."""
    x, y, z, w = values[:, 3:7].T
    heading = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    covariance = values[:, 7:43].reshape(-1, 6, 6)[:, _PLANE[:, None], _PLANE]
    return np.column_stack([values[:, :2], heading]), values[:, 43 + _PLANE], covariance


def stamped_frame(message: bytes) -> str:
    """Frame of a message that begins with a std_msgs/Header."""
    data = CdrReader(message)
    data.stamp()
    return data.text()


def inertial_layout(frame: str = BASE) -> Layout:
    """sensor_msgs/Imu on a frame; open: the numbers of `inertial_values`."""
    return CdrWriter().stamp().text(frame).doubles(4 + 9 + 3 + 9 + 3 + 9).layout()


def inertial_plane(values: Array) -> tuple[Array, Array]:
    """Turning rates (N,) and accelerations (N, 2) from rows (N, 37) of sensor_msgs/Imu."""
    return values[:, 15], values[:, 25:27]


def inertial_values(rate: float, acceleration: Array) -> Array:
    """Turning rate and acceleration (2,) as the 37 numbers of a sensor_msgs/Imu that states no orientation."""
    values = np.zeros(37)
    values[3], values[4] = 1.0, -1.0  # no orientation: its covariance starts with -1
    values[15], values[25:27] = rate, acceleration
    return values


def log_message(nanoseconds: int, event: Event) -> bytes:
    """rcl_interfaces/Log; the text ends with the program line, where there is one."""
    out = CdrWriter().stamp(nanoseconds).byte(LEVELS[event.level]).text(event.source)
    return out.text(event.text + _line_note(event.line)).text(event.file).text("").uint32(event.line).message()


def log_event(message: bytes) -> Event:
    """Event that `log_message` wrote."""
    data = CdrReader(message)
    nanoseconds, number, source, text = data.stamp(), data.byte(), data.text(), data.text()
    file = data.text()
    data.text()
    line = data.uint32()
    level = next((name for name, value in reversed(LEVELS.items()) if value <= number), "debug")
    return Event(nanoseconds / 1e9, level, source, text.removesuffix(_line_note(line)), line, file)


def image_message(nanoseconds: int, frame: str, image: Photograph) -> bytes:
    """sensor_msgs/CompressedImage."""
    return CdrWriter().stamp(nanoseconds).text(frame).text(image.format).blob(image.data).message()


def marker_message(nanoseconds: int, markers: Sequence[Marker]) -> bytes:
    """visualization_msgs/MarkerArray of markers that stay, each fixed in its frame."""
    out = CdrWriter().uint32(len(markers))
    for number, marker in enumerate(markers):
        out.stamp().text(marker.frame).text(marker.shape).uint32(number).uint32(MARKERS[marker.shape]).uint32(0)
        out.doubles(7 + 3)
        for part in marker.colour:
            out.float32(part)
        out.uint32(0).uint32(0).byte(1)  # no end of its life; it goes along with its frame
        out.uint32(0).uint32(0).text("")  # points, colours, texture: its name, stamp, frame, format and bytes
        out.uint32(0).uint32(0).text("").text("").blob(b"")
        out.uint32(0).text(marker.frame).text("").text("").blob(b"").byte(0)
    poses = pose_rows(np.array([marker.pose for marker in markers]).reshape(-1, 4, 4))
    sizes = np.array([marker.size for marker in markers]).reshape(-1, 3)
    return out.layout().pack(nanoseconds, np.hstack([poses, sizes]))


def _line_note(line: int) -> str:
    return f" (line {line})" if line else ""
