"""Reading a recording back as arrays."""

from __future__ import annotations

import struct
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording.codecs import CODECS, transform_groups
from holonom.app.recording.heard import Messages
from holonom.app.recording.messages import WORLD, log_event
from holonom.app.recording.pieces import Pieces, Said, read_pieces
from holonom.app.recording.recording import COMPLETE, CUT_OFF, Recording
from holonom.app.recording.scope import bare
from holonom.app.recording.tracks import FrameTrack, Track
from holonom.errors import InputError, UnknownName
from holonom.signals import TOPICS, Event, Signal, Topic

__all__ = ["FORMER", "read_recording"]

Array = NDArray[np.float64]

FORMER = {
    "/joint_reference": "/commanded/joint_states",
    "/motor_current": "/truth/motor_current",
    "/motor_voltage": "/commanded/motor_voltage",
    "/tf": "/truth/tf",
    "/tool_pose": "/truth/tool_pose",
    "/base_reference": "/commanded/odom",
    "/wheel_force": "/truth/wheel_force",
    "/wheel_slip": "/truth/wheel_slip",
    "/wheel_residual": "/estimated/wheel_residual",
}
"""What topics were called before a recording said of each what it is."""

Heard = dict[str, tuple[Topic, Messages]]
Frames = dict[tuple[str, str], FrameTrack]


def read_recording(path: str | Path, *, robot: str | None = None, topics: Sequence[Topic] = TOPICS) -> Recording:
    """Read a file that `Recorder` wrote, also one that a killed run left.

    Parameters
    ----------
    path
        The MCAP file.
    robot
        Which of several; the first one unless given.
    topics
        The table of signals.

    Returns
    -------
    Recording
        All topics as arrays; SI units, radians, frames in world. Where the file ends in the middle `ended` says so, and
        all whole pieces before that are there.

    Raises
    ------
    InputError
        The file is missing, no MCAP recording, or damaged: up to where it can be read.
    UnknownName
        No such robot.
    """
    path = Path(path)
    pieces = read_pieces(path)
    robots = tuple(dict.fromkeys(said.robot for said in pieces.topics if not _is_shared(said, topics)))
    if robot is not None and robot not in (robots or ("",)):
        raise UnknownName("robot in the recording", robot, robots)
    chosen = robot if robot is not None else next(iter(robots), "")
    heard = _heard(pieces, chosen, topics)
    try:
        return _recording(pieces, heard, chosen, robots)
    except (struct.error, ValueError, IndexError, StopIteration) as error:
        raise InputError(f"{path} holds a message that is damaged ({error}); record it again") from error


def _is_shared(said: Said, topics: Sequence[Topic]) -> bool:
    return any(topic.shared and topic.name == said.topic for topic in topics)


def _heard(pieces: Pieces, robot: str, topics: Sequence[Topic]) -> Heard:
    """Messages of a robot by the topic's name in the table, with its row."""
    heard: Heard = {}
    for said, messages in pieces.topics.items():
        name = said.topic if said.kind else FORMER.get(said.topic, said.topic)
        name = name.removeprefix(f"/{robot}") if robot and said.robot == robot else name
        row = _row(name, topics)
        if row is not None and (row.shared or said.robot == robot) and len(messages):
            heard[name] = row, messages
    return heard


def _row(name: str, topics: Sequence[Topic]) -> Topic | None:
    """Row of a topic; of one with open places by what stands before them."""
    for topic in topics:
        if topic.name == name or ("{" in topic.name and name.startswith(topic.name.partition("{")[0])):
            return topic
    return None


def _recording(pieces: Pieces, heard: Heard, robot: str, robots: tuple[str, ...]) -> Recording:
    tracks = {name: CODECS[row.type].decode(row, messages) for name, (row, messages) in heard.items()}
    joints = (track.names for track in tracks.values() if track.names)
    frames = {name: track for (parent, name), track in _frames(heard, "/truth/tf", robot).items() if parent == WORLD}
    return Recording(
        tracks=tracks,
        frames=frames,
        tree=_frames(heard, "/tf", robot),
        signals=_signals(tracks),
        events=_events(heard, robot),
        joint_names=tuple(bare(name, robot, ".") for name in next(joints, ())),
        robot=robot,
        robots=robots,
        attachments=pieces.attachments,
        metadata=pieces.metadata,
        ended=COMPLETE if pieces.whole else CUT_OFF,
    )


def _frames(heard: Heard, topic: str, robot: str) -> Frames:
    """Frames by (parent, name)."""
    if topic not in heard:
        return {}
    parts: dict[tuple[str, str], list[tuple[Array, Array]]] = defaultdict(list)
    for frames, time, values in transform_groups(heard[topic][1]):
        for i, (parent, name) in enumerate(frames):
            key = bare(parent, robot, "/"), bare(name, robot, "/")
            parts[key].append((time, values[:, 7 * i : 7 * i + 7]))
    return {key: _frame_track(pieces) for key, pieces in parts.items()}


def _frame_track(pieces: Sequence[tuple[Array, Array]]) -> FrameTrack:
    time = np.concatenate([piece[0] for piece in pieces])
    values = np.concatenate([piece[1] for piece in pieces])
    order = np.argsort(time, kind="stable")
    return FrameTrack(time[order], values[order, :3], values[order, 3:])


def _signals(tracks: Mapping[str, Track]) -> tuple[Signal, ...]:
    found = [
        Signal(float(time), int(name.removeprefix("/signals/")), bool(on))
        for name, track in tracks.items()
        if name.startswith("/signals/")
        for time, on in zip(track.time, track.fields["on"], strict=True)
    ]
    return tuple(sorted(found, key=lambda signal: signal.time))


def _events(heard: Heard, robot: str) -> tuple[Event, ...]:
    if "/rosout" not in heard:
        return ()
    events = map(log_event, heard["/rosout"][1])
    return tuple(Event(e.time, e.level, bare(e.source, robot, "."), e.text, e.line) for e in events)
