"""Writing a recording, record by record, as the run goes."""

from __future__ import annotations

import mimetypes
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from holonom.app.recording.format.codecs import CODECS, Encode
from holonom.app.recording.format.growing import GrowingFile
from holonom.app.recording.format.pieces import CLOCK, ZERO
from holonom.app.recording.format.schemas import schema_text
from holonom.app.recording.scope import Scope
from holonom.errors import OutputFault, UnknownName
from holonom.signals import TOPICS, Record, Signal, Sink, Topic

__all__ = ["EPOCH", "Recorder"]

EPOCH = 946_684_800_000_000_000
"""Stamp, ns, of the beginning of simulated time: 2000-01-01 00:00 UTC. Tools of ROS take a stamp of 0 for none at all;
a fixed one leaves equal runs equal files."""
KEPT = (
    "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n  deadline: {sec: 2147483647, nsec: 4294967295}\n"
    "  lifespan: {sec: 2147483647, nsec: 4294967295}\n  liveliness: 1\n"
    "  liveliness_lease_duration: {sec: 2147483647, nsec: 4294967295}\n  avoid_ros_namespace_conventions: false\n"
)
"""Quality of service of what is said once: kept for who subscribes later (transient local), as rosbag2 writes it."""
PIECE = 100_000_000
"""Simulated time, ns, after which what was recorded is handed to the operating system; a killed run loses no more."""


class Recorder:
    """A `signals.Sink` that writes an MCAP file of ROS 2 messages.

    The file holds simulated time only, from `EPOCH` on, so that equal runs give equal files, to the byte. Use it as a
    context manager: the file is complete however the block is left. It grows by a chunk for each 0.1 s of simulated
    time, so that what a killed process leaves can be read up to there.

    Parameters
    ----------
    path
        The file to write.
    joint_names
        Names of the axes or wheels, in the order of the arrays in the records.
    tool
        Which of the frames also goes to `/truth/tool_pose`.
    robot
        Name of the robot where there are several: its topics are `/<robot>/...`, its joints `<robot>.<joint>`, its
        frames `<robot>/<frame>`. `scoped` gives sinks for the others.
    attachments
        Files that stand at the beginning, by name: what the run is of.
    metadata
        Words that stand there, too, by name.
    topics
        The table of signals.

    Raises
    ------
    OutputError
        The file cannot be made.
    """

    __slots__ = ("_begin", "_channels", "_flushed", "_own", "_schemas", "_stream", "_topics", "_writer")

    def __init__(
        self,
        path: str | Path,
        joint_names: Sequence[str] = (),
        *,
        tool: str = "tool",
        robot: str = "",
        attachments: Mapping[str, bytes] | None = None,
        metadata: Mapping[str, Mapping[str, str]] | None = None,
        topics: Sequence[Topic] = TOPICS,
    ) -> None:
        scope = Scope(robot, tuple(joint_names), tool)
        self._stream = GrowingFile(Path(path))
        self._topics = tuple(topics)
        self._writer = Writer(self._stream, compression=CompressionType.ZSTD)  # type: ignore[arg-type]
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._flushed: int | None = None
        self._begin: float | None = None
        self._own = _RobotSink(self, scope, self._topics)
        try:
            self._writer.start(profile=Profile.ROS2, library="holonom")
            for name, data in (attachments or {}).items():
                kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
                self._writer.add_attachment(0, 0, name, kind, data)
            for name, words in {CLOCK: {ZERO: str(EPOCH)}, **(metadata or {})}.items():
                self._writer.add_metadata(name, dict(words))
            self._writer.flush()  # type: ignore[no-untyped-call]
        except OutputFault:
            self._stream.close()
            raise

    def put(self, record: Record) -> None:
        """Take one record; see `holonom.signals.Sink`. Once the disk is full nothing is taken any more.

        Raises
        ------
        ShapeError
            An array does not have one number per joint or wheel, or one pose per name.
        UnknownName
            A record that no topic is of.
        OutputFault
            The disk is full, or gone: once, at the first record that could not be kept.
        """
        self._own.put(record)

    def scoped(self, robot: str, joint_names: Sequence[str], *, tool: str = "tool") -> Sink:
        """Return the sink of another robot, which records into the same file."""
        return _RobotSink(self, Scope(robot, tuple(joint_names), tool), self._topics)

    def began(self, time: float) -> float:
        """Time of the first record of any robot, s; `time` is that of one that comes now."""
        if self._begin is None:
            self._begin = time
        return self._begin

    def metadata(self, name: str, words: Mapping[str, str]) -> None:
        """Write words beside the messages, such as how the run ended.

        Raises
        ------
        OutputFault
        """
        if not self._stream.failed:
            self._writer.add_metadata(name, dict(words))

    def write(self, scope: Scope, topic: Topic, name: str, now: int, message: bytes) -> None:
        """Write a message of a robot at a time, ns."""
        if self._stream.failed:
            return
        if self._flushed is None:
            self._flushed = now
        elif now - self._flushed >= PIECE:
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._flushed = now
        called = scope.topic(topic, name)
        if called not in self._channels:
            self._channels[called] = self._channel(scope, topic, called)
        self._writer.add_message(self._channels[called], log_time=now, data=message, publish_time=now)

    def close(self) -> None:
        """Write what is still to be written, with the index, and close the file; again does nothing.

        Raises
        ------
        OutputFault
            The disk is full, or gone.
        """
        if self._stream.closed:
            return
        try:
            if not self._stream.failed:
                self._writer.flush()  # type: ignore[no-untyped-call]
                self._writer.finish()  # type: ignore[no-untyped-call]
                self._stream.flush()
        finally:
            self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self.close()
        except OutputFault:
            if error is None:
                raise

    def _channel(self, scope: Scope, topic: Topic, called: str) -> int:
        if topic.type not in self._schemas:
            text = schema_text(topic.type).encode()
            schema_name = topic.type.replace("/", "/msg/")
            self._schemas[topic.type] = self._writer.register_schema(schema_name, SchemaEncoding.ROS2, text)
        about = {"kind": str(topic.kind), "units": topic.units, "frame": topic.frame, "meaning": topic.meaning}
        about["robot"] = "" if topic.shared else scope.robot
        if topic.kept:
            about["offered_qos_profiles"] = KEPT
        schema = self._schemas[topic.type]
        return self._writer.register_channel(called, MessageEncoding.CDR, schema, about)


class _RobotSink:
    """The records of one robot. A digital signal that is first heard of when it changes was the opposite before."""

    __slots__ = ("_encoders", "_heard", "_recorder", "_scope")

    def __init__(self, recorder: Recorder, scope: Scope, topics: Sequence[Topic]) -> None:
        self._recorder, self._scope = recorder, scope
        self._encoders: dict[type[Record], list[tuple[Topic, Encode]]] = {}
        self._heard: set[int] = set()
        for topic in topics:
            encode = CODECS[topic.type].encoder(topic, scope)
            self._encoders.setdefault(topic.record, []).append((topic, encode))

    def put(self, record: Record) -> None:
        if type(record) not in self._encoders:
            raise UnknownName("record", type(record).__name__, [kind.__name__ for kind in self._encoders])
        begin = self._recorder.began(record.time)
        if isinstance(record, Signal) and record.number not in self._heard:
            self._heard.add(record.number)
            if record.time > begin:
                self.put(Signal(begin, record.number, not record.on))
        now = EPOCH + round(record.time * 1e9)
        for topic, encode in self._encoders[type(record)]:
            message = encode(now, record)
            if message is not None:
                name = _open(topic.name, record) if "{" in topic.name else topic.name
                self._recorder.write(self._scope, topic, name, now, message)


def _open(name: str, record: Any) -> str:
    """Name of a topic with the record's fields in their braces."""
    return name.format_map({field: getattr(record, field) for field in type(record).__dataclass_fields__})
