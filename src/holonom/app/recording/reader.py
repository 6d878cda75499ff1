"""Reading a recording back as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from holonom.app.recording.format.decoded import Decoded, Frames
from holonom.app.recording.format.messages import WORLD
from holonom.app.recording.format.pieces import Pieces, read_pieces
from holonom.app.recording.format.topic_messages import Messages, Stream
from holonom.app.recording.recording import COMPLETE, CUT_OFF, Recording
from holonom.app.recording.scope import bare
from holonom.app.recording.tracks import Track
from holonom.errors import UnknownName
from holonom.signals import TOPICS, Signal, Topic

__all__ = ["FORMER", "read_recording", "read_robots"]

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
"""What topics were called before a recording stream of each what it is."""

LONGEST_NUMBER = 10
"""Digits that a signal's number is shorter than."""
Heard = dict[Stream, Decoded]


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
        All topics as arrays; SI units, radians, frames in world. Where the file ends in the middle `ended` says so;
        what is damaged is not there, and `missing` says from when to when, and why.

    Raises
    ------
    InputError
        The file is not there, no MCAP recording, or so damaged that nothing of it can be read.
    UnknownName
        No such robot.
    """
    pieces, by_stream = _read(Path(path), topics)
    robots = _robots(pieces, topics)
    if robot is not None and robot not in (robots or ("",)):
        raise UnknownName("robot in the recording", robot, robots)
    return _recordings(pieces, by_stream, (robot if robot is not None else next(iter(robots), ""),), robots)[0]


def read_robots(path: str | Path, *, topics: Sequence[Topic] = TOPICS) -> dict[str, Recording]:
    """Read a file once for all of its robots.

    Returns
    -------
    dict
        Under "" what belongs to no robot, with frames and sources of events by their full names; under each robot's
        name what `read_recording` gives of it. Of a robot that is alone: "" only, with all there is.

    Raises
    ------
    InputError
        As `read_recording`.
    """
    pieces, by_stream = _read(Path(path), topics)
    robots = _robots(pieces, topics)
    names = tuple(dict.fromkeys(("", *robots)))
    return dict(zip(names, _recordings(pieces, by_stream, names, robots), strict=True))


def _read(path: Path, topics: Sequence[Topic]) -> tuple[Pieces, Heard]:
    by_stream: Heard = {}

    def take(stream: Stream, messages: Messages) -> None:
        if stream not in by_stream:
            row = _row(_name(stream), topics)
            fits = row is not None and stream.type in ("", row.type)
            by_stream[stream] = Decoded(_name(stream), row if fits else None)
        by_stream[stream].add(messages)

    return read_pieces(path, take), by_stream


def _robots(pieces: Pieces, topics: Sequence[Topic]) -> tuple[str, ...]:
    shared = {topic.name for topic in (*TOPICS, *topics) if topic.shared}
    return tuple(dict.fromkeys(stream.robot for stream in pieces.topics if stream.topic not in shared))


def _name(stream: Stream) -> str:
    """Name of a topic in the table."""
    name = stream.topic if stream.kind else FORMER.get(stream.topic, stream.topic)
    return name.removeprefix(f"/{stream.robot}") if stream.robot else name


def _row(name: str, topics: Sequence[Topic]) -> Topic | None:
    """Row of a topic; of one with an open place by what stands before it, and whether what stands in it fits."""
    for topic in topics:
        before, _, place = topic.name.partition("{")
        if topic.name == name or (place and name.startswith(before) and _fits(place, name.removeprefix(before))):
            return topic
    return None


def _fits(place: str, word: str) -> bool:
    return word.isdecimal() and word.isascii() and len(word) < LONGEST_NUMBER if place == "number}" else bool(word)


def _recordings(pieces: Pieces, by_stream: Heard, names: Sequence[str], robots: tuple[str, ...]) -> list[Recording]:
    """One for each name; what they share is made once."""
    shared = {decoded.name: decoded for decoded in by_stream.values() if decoded.row is not None and decoded.row.shared}
    frames = {name: track for (parent, name), track in _frames(shared, "/truth/tf").items() if parent == WORLD}
    tree, events = _frames(shared, "/tf"), shared["/rosout"].events if "/rosout" in shared else ()
    common = {name: decoded.track() for name, decoded in shared.items() if decoded.read}
    lacking = [missing for decoded in by_stream.values() if (missing := decoded.missing()) is not None]
    found = []
    for robot in names:
        own = {
            stream: decoded
            for stream, decoded in by_stream.items()
            if decoded.row is not None and not decoded.row.shared
        }
        mine = [decoded for stream, decoded in own.items() if stream.robot == robot and decoded.read]
        tracks = {decoded.name: decoded.track() for decoded in mine}
        joints = next((track.names for track in tracks.values() if track.names), ())
        found.append(
            Recording(
                tracks={**tracks, **common},
                frames={bare(name, robot, "/"): track for name, track in frames.items()},
                tree={(bare(a, robot, "/"), bare(b, robot, "/")): track for (a, b), track in tree.items()},
                signals=_signals(tracks),
                events=tuple(replace(event, source=bare(event.source, robot, ".")) for event in events),
                joint_names=tuple(bare(name, robot, ".") for name in joints),
                robot=robot,
                robots=robots,
                attachments=pieces.attachments,
                metadata=pieces.metadata,
                ended=COMPLETE if pieces.whole else CUT_OFF,
                missing=(*pieces.missing, *lacking),
            )
        )
    return found


def _frames(shared: Mapping[str, Decoded], topic: str) -> Frames:
    return shared[topic].frames() if topic in shared else {}


def _signals(tracks: Mapping[str, Track]) -> tuple[Signal, ...]:
    found = [
        Signal(float(time), int(name.removeprefix("/signals/")), bool(on))
        for name, track in tracks.items()
        if name.startswith("/signals/")
        for time, on in zip(track.time, track.fields["on"], strict=True)
    ]
    return tuple(sorted(found, key=lambda signal: signal.time))
