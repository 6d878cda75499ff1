"""Logs in MCAP files and rosbag2: wheel angles as sensor_msgs/JointState, the truth as odometry, poses or transforms.

The first topic of each type counts, unless another is named (`/joint_states` and `/odom` when written here); of the
types of `TRUTHS` the first that is there. Joints are found by the drive's wheel names, unless others are given; the
tricycle's steering is the joint `front_steering`. Poses are interpolated to the times of the joints. Any file with
these messages in little-endian CDR does, such as `ros2 bag` writes.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from holonom.app.odometry_log.log import Columns
from holonom.app.odometry_log.recorded.bag import DAMAGED, messages_of
from holonom.app.odometry_log.recorded.truth_messages import TRUTHS, poses_of
from holonom.app.odometry_log.table import Table
from holonom.app.recording.format.cdr import ENCAPSULATION, CdrReader
from holonom.app.recording.format.messages import (
    JointMessage,
    joint_layout,
    joint_message,
    odometry_layout,
    odometry_values,
)
from holonom.app.recording.format.schemas import schema_text
from holonom.arrays import Array
from holonom.errors import LogError, OutputError
from holonom.mobile.calibration import Run

__all__ = ["JOINTS", "ODOMETRY", "read_mcap_table", "write_mcap"]


JOINTS, ODOMETRY = "sensor_msgs/JointState", "nav_msgs/Odometry"
SUFFIX = "_steering"


def read_mcap_table(
    path: Path,
    called: Columns,
    *,
    joints_topic: str | None = None,
    truth_topic: str | None = None,
    names: Mapping[str, str] | None = None,
    frame: str | None = None,
) -> Table:
    """Running wheel angles (rad), steering and truth of a recording, a row for each JointState.

    Parameters
    ----------
    path : MCAP file, rosbag2 database or folder of one.
    called : names of the drive's wheels, and of those that are steered.
    joints_topic, truth_topic : of the wheels' angles and of the truth; the first of each type unless given.
    names : of the joints, where they differ from those of the wheels.
    frame : of the base in transforms; its usual names, or the only one, unless given.

    Raises
    ------
    LogError
        No MCAP file, another encoding, no joints, or joints without the drive's wheels.
    """
    messages = _messages(path, joints_topic, truth_topic)
    if not messages.get(JOINTS):
        raise LogError(f"{path}: no {JOINTS} messages; record the wheels' angles as joint states")
    joints = [_joint_message(path, data) for data in messages[JOINTS]]
    wanted = [(names or {}).get(name, name) for name in _joints(called)]
    kind = joints[0]
    if any(one.names != kind.names for one in joints):
        raise LogError(f"{path}: {JOINTS} messages of different joints; name the topic of the wheels alone")
    missing = [name for name in wanted if name not in kind.names]
    if missing:
        raise LogError(
            f"{path}: no joint {', '.join(missing)}; there is {', '.join(kind.names)}: name joints as wheels"
        )
    at = [kind.names.index(name) for name in wanted]
    rows = np.stack([_joint_values(path, data, one) for data, one in zip(messages[JOINTS], joints, strict=True)])
    values = np.column_stack([rows[:, 0], rows[:, 1:][:, at]])
    columns = ("time", *called.wheels, *called.steering)
    kind_of_truth = next((known for known in TRUTHS if messages.get(known)), None)
    if kind_of_truth is not None:
        values = np.column_stack([values, _truth_at(path, kind_of_truth, messages[kind_of_truth], values[:, 0], frame)])
        columns = (*columns, "x", "y", "theta")
    if len(values) < 2:
        raise LogError(f"{path}: {len(values)} samples; two or more are expected: the run was not recorded")
    table = Table(path, columns, values, range(1, len(values) + 1))
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        table.fault(int(bad[0, 0]), columns[bad[0, 1]], "NaN or infinity came; finite numbers are expected")
    return table


def write_mcap(path: Path, run: Run, called: Columns, *, others: Mapping[str, Array] | None = None) -> None:
    """Write a run: running wheel angles on /joint_states, the truth, where there is one, on /odom.

    Running angles tell turns between samples only: a run whose first sample has turns gets one more, a step before it.

    Parameters
    ----------
    called : names of wheels and of joints that steer.
    others : topic -> poses (N, 3) of other odometry of this run, to look at beside the truth.

    Raises
    ------
    OutputError
    """
    layout = joint_layout(JointMessage(_joints(called), arrays=1))
    odometry = odometry_layout()
    poses = {"/odom": run.truth, **(others or {})}
    if run.turns[0].any():
        run = _from_rest(run)
        poses = {topic: np.concatenate([rows[:1], rows]) for topic, rows in poses.items()}
    angles = np.column_stack([np.cumsum(run.turns, axis=0), run.steering])
    stamps = np.rint((run.time - min(run.time[0], 0.0)) * 1e9).astype(np.int64)
    try:
        with path.open("wb") as stream:
            writer = Writer(stream, compression=CompressionType.ZSTD)
            writer.start(profile=Profile.ROS2, library="holonom")
            joints = _channel(writer, "/joint_states", JOINTS)
            channels = [(_channel(writer, topic, ODOMETRY), rows) for topic, rows in poses.items() if len(rows)]
            for k, stamp in enumerate(stamps.tolist()):
                writer.add_message(joints, log_time=stamp, publish_time=stamp, data=layout.pack(stamp, angles[k]))
                for channel, rows in channels:
                    data = odometry.pack(stamp, odometry_values(rows[k], np.zeros(3), np.zeros((3, 3))))
                    writer.add_message(channel, log_time=stamp, publish_time=stamp, data=data)
            writer.finish()  # type: ignore[no-untyped-call]
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}; give a folder that can be written") from None


def _joints(called: Columns) -> tuple[str, ...]:
    return (*called.wheels, *(name + SUFFIX for name in called.joints))


def _from_rest(run: Run) -> Run:
    still = np.zeros_like(run.turns[:1])
    earlier = 2.0 * run.time[:1] - run.time[1:2]
    parts = ([earlier, run.time], [still, run.turns], [run.truth[:1], run.truth], [run.steering[:1], run.steering])
    time, turns, truth, steering = (np.concatenate(part) for part in parts)
    return Run(run.name, time, turns, truth, steering)


def _channel(writer: Writer, topic: str, kind: str) -> int:
    schema = writer.register_schema(kind.replace("/", "/msg/"), SchemaEncoding.ROS2, schema_text(kind).encode())
    return writer.register_channel(topic, MessageEncoding.CDR, schema)


def _messages(path: Path, joints: str | None, truth: str | None) -> Mapping[str, list[bytes]]:
    """Messages of the named, or first, topic of each type: of joints, and of one type that tells the truth."""
    found: dict[str, list[bytes]] = defaultdict(list)
    topics: dict[str, str] = {}
    for kind, topic, data in messages_of(path, (JOINTS, *TRUTHS)):
        named = joints if kind == JOINTS else truth
        if topics.setdefault(kind, named if named is not None else topic) == topic:
            found[kind].append(data)
    return found


def _joint_message(path: Path, data: bytes) -> JointMessage:
    try:
        return joint_message(data)
    except DAMAGED as error:
        raise LogError(f"{path}: a damaged {JOINTS} ({error or type(error).__name__}); record it again") from None


def _joint_values(path: Path, data: bytes, kind: JointMessage) -> Array:
    """Time, s, and positions."""
    if kind.arrays == 0:
        raise LogError(f"{path}: a {JOINTS} without positions; record the wheels' angles")
    row = np.frombuffer(data[len(ENCAPSULATION) :], dtype=np.uint8)[None]
    positions = joint_layout(kind).unpack(row)[0, : len(kind.names)]
    return np.concatenate([[CdrReader(data).stamp() / 1e9], positions])


def _truth_at(path: Path, kind: str, messages: Sequence[bytes], time: Array, frame: str | None) -> Array:
    """Poses (N, 3) at the joints' times, between those of the messages."""
    try:
        stamps, poses = poses_of(kind, messages, frame, str(path))
    except DAMAGED as error:
        raise LogError(f"{path}: a damaged {kind} ({error or type(error).__name__}); record it again") from None
    if time[0] < stamps[0] - 0.5 or time[-1] > stamps[-1] + 0.5:
        raise LogError(
            f"{path}: joints from {time[0]:g} to {time[-1]:g} s, truth from {stamps[0]:g} to {stamps[-1]:g} s; cut the "
            "recording to where both are there"
        )
    columns = [poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2])]
    return np.stack([np.interp(time, stamps, column) for column in columns], axis=1)
