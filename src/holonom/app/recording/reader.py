"""Reading a recording back as arrays."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray

from holonom.app.recording.cdr import ENCAPSULATION, Layout
from holonom.app.recording.messages import (
    array_layout,
    array_size,
    joint_layout,
    joint_message,
    log_event,
    odometry_layout,
    odometry_plane,
    pose_layout,
    transform_layout,
    transform_names,
)
from holonom.app.recording.tracks import BaseTrack, ContactTrack, DriveTrack, FrameTrack, JointTrack, Recording
from holonom.errors import InputError
from holonom.signals import Signal

__all__ = ["read_recording"]

Array = NDArray[np.float64]


class _Topic(NamedTuple):
    times: list[int]
    messages: list[bytes]


class _Group(NamedTuple):
    """Messages of one layout: what fixes it, their times (N,) in s and their open doubles (N, k)."""

    kind: Any
    time: Array
    values: Array


def read_recording(path: str | Path) -> Recording:
    """Read a file that `Recorder` wrote.

    Parameters
    ----------
    path
        The MCAP file.

    Returns
    -------
    Recording
        All topics as arrays; SI units, radians, frames in world.

    Raises
    ------
    InputError
        The file is missing, or no MCAP recording.
    """
    topics = _read_topics(Path(path))
    names, joints = _joint_track(topics["/joint_states"])
    reference_names, reference = _joint_track(topics["/joint_reference"])
    time, current = _array_track(topics["/motor_current"])
    _, voltage = _array_track(topics["/motor_voltage"])
    force_time, force = _array_track(topics["/wheel_force"])
    _, slip = _array_track(topics["/wheel_slip"])
    _, residual = _array_track(topics["/wheel_residual"])
    tool = _groups(topics["/tool_pose"], lambda message: None, lambda kind: pose_layout())
    return Recording(
        joint_names=names or reference_names,
        joints=joints,
        reference=reference,
        drives=DriveTrack(time, current, voltage),
        base=_base_track(topics["/odom"]),
        base_reference=_base_track(topics["/base_reference"]),
        contacts=ContactTrack(force_time, force, slip, residual),
        tool=_frame_track([(group.time, group.values) for group in tool]),
        frames=_frames(topics["/tf"]),
        signals=_signals(topics),
        events=tuple(log_event(message) for message in topics["/rosout"].messages),
    )


def _read_topics(path: Path) -> dict[str, _Topic]:
    topics: dict[str, _Topic] = defaultdict(lambda: _Topic([], []))
    channels: dict[int, _Topic] = {}
    try:
        with path.open("rb") as stream:
            for record in StreamReader(stream).records:
                if isinstance(record, Message):
                    topic = channels[record.channel_id]
                    topic.times.append(record.log_time)
                    topic.messages.append(record.data)
                elif isinstance(record, Channel):
                    channels[record.id] = topics[record.topic]
    except OSError as error:
        raise InputError(f"cannot read the recording {path}: {error.strerror}; give a recording.mcap") from error
    except McapError as error:
        raise InputError(f"{path} is no MCAP recording ({error}); give a recording.mcap of a run") from error
    return topics


def _groups(topic: _Topic, kind_of: Callable[[bytes], Any], layout_of: Callable[[Any], Layout]) -> list[_Group]:
    """Messages of a topic, sorted by layout; within one layout in the order of the file."""
    times = np.array(topic.times, dtype=np.int64) / 1e9
    sizes = np.array([len(message) for message in topic.messages])
    groups = []
    for size in dict.fromkeys(sizes.tolist()):
        at = np.flatnonzero(sizes == size)
        rows = np.frombuffer(b"".join(topic.messages[i] for i in at), dtype=np.uint8).reshape(len(at), size)
        rows = rows[:, len(ENCAPSULATION) :]
        while len(at):
            kind = kind_of(topic.messages[at[0]])
            layout = layout_of(kind)
            same = layout.matches(rows)
            assert same[0], "the first message has the layout that was read from it"
            groups.append(_Group(kind, times[at[same]], layout.unpack(rows[same])))
            at, rows = at[~same], rows[~same]
    return groups


def _joint_track(topic: _Topic) -> tuple[tuple[str, ...], JointTrack]:
    groups = _groups(topic, joint_message, joint_layout)
    if not groups:
        empty = np.empty((0, 0))
        return (), JointTrack(np.empty(0), empty, empty, empty)
    (kind, time, values) = groups[0]
    n = len(kind.names)
    return kind.names, JointTrack(time, values[:, :n], values[:, n : 2 * n], values[:, 2 * n :])


def _array_track(topic: _Topic) -> tuple[Array, Array]:
    groups = _groups(topic, array_size, array_layout)
    return (groups[0].time, groups[0].values) if groups else (np.empty(0), np.empty((0, 0)))


def _base_track(topic: _Topic) -> BaseTrack:
    groups = _groups(topic, lambda message: None, lambda kind: odometry_layout())
    if not groups:
        return BaseTrack(np.empty(0), np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3, 3)))
    pose, twist, covariance = odometry_plane(groups[0].values)
    return BaseTrack(groups[0].time, pose, twist, covariance)


def _frames(topic: _Topic) -> dict[str, FrameTrack]:
    parts: dict[str, list[tuple[Array, Array]]] = defaultdict(list)
    for names, time, values in _groups(topic, transform_names, transform_layout):
        for i, name in enumerate(names):
            parts[name].append((time, values[:, 7 * i : 7 * i + 7]))
    return {name: _frame_track(pieces) for name, pieces in parts.items()}


def _frame_track(pieces: list[tuple[Array, Array]]) -> FrameTrack:
    if not pieces:
        return FrameTrack(np.empty(0), np.empty((0, 3)), np.empty((0, 4)))
    time = np.concatenate([piece[0] for piece in pieces])
    values = np.concatenate([piece[1] for piece in pieces])
    order = np.argsort(time, kind="stable")
    return FrameTrack(time[order], values[order, :3], values[order, 3:])


def _signals(topics: dict[str, _Topic]) -> tuple[Signal, ...]:
    found = [
        Signal(time / 1e9, int(name.removeprefix("/signals/")), message[len(ENCAPSULATION)] != 0)
        for name, topic in topics.items()
        if name.startswith("/signals/")
        for time, message in zip(topic.times, topic.messages, strict=True)
    ]
    return tuple(sorted(found, key=lambda signal: signal.time))
