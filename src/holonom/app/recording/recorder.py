"""Writing a recording, record by record, as the run goes."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from types import TracebackType
from typing import Self, assert_never

import numpy as np
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from holonom.app.recording.cdr import CdrWriter
from holonom.app.recording.messages import (
    JointMessage,
    array_layout,
    inertial_layout,
    inertial_values,
    joint_layout,
    log_message,
    odometry_layout,
    odometry_values,
    pose_layout,
    transform_layout,
)
from holonom.app.recording.schemas import schema_text
from holonom.errors import OutputError
from holonom.signals import (
    BaseCommand,
    BaseState,
    DriveState,
    Event,
    FramePoses,
    Inertial,
    JointCommand,
    JointState,
    Record,
    Signal,
    WheelContact,
)

__all__ = ["Recorder"]

Array = NDArray[np.float64]

_TOPICS = {
    "/joint_states": "sensor_msgs/JointState",
    "/joint_reference": "sensor_msgs/JointState",
    "/motor_current": "std_msgs/Float64MultiArray",
    "/motor_voltage": "std_msgs/Float64MultiArray",
    "/tf": "tf2_msgs/TFMessage",
    "/tool_pose": "geometry_msgs/PoseStamped",
    "/odom": "nav_msgs/Odometry",
    "/base_reference": "nav_msgs/Odometry",
    "/imu": "sensor_msgs/Imu",
    "/wheel_force": "std_msgs/Float64MultiArray",
    "/wheel_slip": "std_msgs/Float64MultiArray",
    "/wheel_residual": "std_msgs/Float64MultiArray",
    "/rosout": "rcl_interfaces/Log",
}
_SIGNAL_TYPE = "std_msgs/Bool"


class Recorder:
    """A `signals.Sink` that writes an MCAP file of ROS 2 messages.

    The file holds simulated time only, so that equal runs give equal files, to the byte. Use it as a context
    manager: the file is complete however the block is left.

    Parameters
    ----------
    path
        The file to write.
    joint_names
        Names of the axes or wheels, in the order of the arrays in the records.
    tool
        Which of the frames also goes to `/tool_pose`.

    Raises
    ------
    OutputError
        The file cannot be written.
    """

    __slots__ = (
        "_array",
        "_channels",
        "_inertial",
        "_odometry",
        "_pose",
        "_reference",
        "_schemas",
        "_state",
        "_stream",
        "_tool",
        "_transforms",
        "_writer",
    )

    def __init__(self, path: str | Path, joint_names: Sequence[str], *, tool: str = "tool") -> None:
        try:
            self._stream = open(path, "wb")  # noqa: SIM115  (closed in `close`)
        except OSError as error:
            raise OutputError(
                f"cannot write the recording {path}: {error.strerror}; give a folder that can be written"
            ) from error
        names = tuple(joint_names)
        self._state = joint_layout(JointMessage(names, arrays=3))
        self._reference = joint_layout(JointMessage(names, arrays=2))
        self._array = array_layout(len(names))
        self._pose = pose_layout()
        self._odometry = odometry_layout()
        self._inertial = inertial_layout()
        self._transforms = lru_cache(maxsize=64)(transform_layout)
        self._tool = tool
        self._writer = Writer(self._stream, compression=CompressionType.ZSTD)
        self._writer.start(profile=Profile.ROS2, library="holonom")
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def put(self, record: Record) -> None:
        """Take one record; see `holonom.signals.Sink`.

        Raises
        ------
        ShapeError
            An array does not have one number per joint or wheel, or one pose per name.
        """
        now = round(record.time * 1e9)
        match record:
            case JointState():
                values = np.concatenate([record.position, record.velocity, record.effort])
                self._write("/joint_states", now, self._state.pack(now, values))
            case JointCommand():
                values = np.concatenate([record.position, record.velocity])
                self._write("/joint_reference", now, self._reference.pack(now, values))
            case DriveState():
                self._write("/motor_current", now, self._array.pack(now, record.current))
                self._write("/motor_voltage", now, self._array.pack(now, record.voltage))
            case BaseState():
                values = odometry_values(record.pose, record.twist, record.covariance)
                self._write("/odom", now, self._odometry.pack(now, values))
            case BaseCommand():
                values = odometry_values(record.pose, record.twist, np.zeros((3, 3)))
                self._write("/base_reference", now, self._odometry.pack(now, values))
            case Inertial():
                self._write("/imu", now, self._inertial.pack(now, inertial_values(record.rate, record.acceleration)))
            case WheelContact():
                self._write("/wheel_force", now, self._array.pack(now, record.force))
                self._write("/wheel_slip", now, self._array.pack(now, record.slip))
                self._write("/wheel_residual", now, self._array.pack(now, record.residual))
            case FramePoses():
                self._put_frames(now, record)
            case Signal():
                self._write(f"/signals/{record.number}", now, CdrWriter().byte(record.on).message())
            case Event():
                self._write("/rosout", now, log_message(now, record))
            case _:
                assert_never(record)

    def close(self) -> None:
        """Write what is still to be written, with the index, and close the file; again does nothing."""
        if not self._stream.closed:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _put_frames(self, now: int, record: FramePoses) -> None:
        values = _pose_rows(record.poses)
        self._write("/tf", now, self._transforms(record.names).pack(now, values))
        if self._tool in record.names:
            tool = values[record.names.index(self._tool)]
            self._write("/tool_pose", now, self._pose.pack(now, tool))

    def _write(self, topic: str, now: int, message: bytes) -> None:
        if topic not in self._channels:
            self._channels[topic] = self._channel(topic, _TOPICS.get(topic, _SIGNAL_TYPE))
        self._writer.add_message(self._channels[topic], log_time=now, data=message, publish_time=now)

    def _channel(self, topic: str, kind: str) -> int:
        if kind not in self._schemas:
            name = kind.replace("/", "/msg/")
            text = schema_text(kind).encode()
            self._schemas[kind] = self._writer.register_schema(name, SchemaEncoding.ROS2, text)
        return self._writer.register_channel(topic, MessageEncoding.CDR, self._schemas[kind])


def _pose_rows(poses: Array) -> Array:
    """Rows (k, 7), x y z and quaternion x y z w, of poses (k, 4, 4)."""
    rows = np.empty((len(poses), 7))
    rows[:, :3] = poses[:, :3, 3]
    rows[:, 3:] = Rotation.from_matrix(poses[:, :3, :3]).as_quat(canonical=True)
    return rows
