"""What is in an MCAP file, whole or not: messages by topic, attachments and metadata, and what is missing."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from holonom.app.recording.format.container import (
    ATTACHMENT,
    CHANNEL,
    MAGIC,
    MESSAGE,
    MESSAGE_HEAD,
    METADATA,
    SCHEMA,
    Damage,
    Reader,
    Record,
    pairs_at,
    text_at,
    texts_at,
)
from holonom.app.recording.format.missing import Missing
from holonom.app.recording.format.topic_messages import Messages, Stream
from holonom.errors import InputError

__all__ = ["CLOCK", "ZERO", "Pieces", "Taker", "read_pieces"]

BLOCK = 8_000_000
"""Bytes of one topic that are held before they are made into arrays: an hour of messages is ten times its arrays."""
CDR = "cdr"
CLOCK, ZERO = "clock", "zero_ns"
"""Words that say which stamp, ns, is the beginning of simulated time."""
LATEST = 2**63
"""ns; no clock gets there."""
BROKEN = (struct.error, ValueError)
"""What a record raises that is not laid out as its kind is."""

Taker = Callable[[Stream, Messages], None]
"""What takes the messages of a topic, some at a time, in their order."""


@dataclass(slots=True)
class Pieces:
    """What is in a file: messages that were not taken yet, what is missing, and whether it has its end (`whole`)."""

    topics: dict[Stream, Messages] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    missing: list[Missing] = field(default_factory=list)
    whole: bool = True
    damaged: bool = False
    """whether anything else than its end is missing"""
    count: int = 0
    """messages so far, taken or not"""
    last: float | None = None
    """time of the latest of them, s"""

    def lose(self, what: str, *, rest: bool = False) -> None:
        """Note that something is missing here; what is missing in a row is one. `rest`: it is what a cut took away."""
        self.damaged |= not rest
        if self.missing and self.missing[-1].count == self.count:
            self.missing[-1] = self.missing[-1].more(what, rest=rest)
        else:
            self.missing.append(Missing(self.last, None, (what,), self.count, rest))

    def reach(self, time: float) -> None:
        """Note a message of a time, s: what was missing before it ends here."""
        if self.missing and self.missing[-1].count == self.count and not self.missing[-1].rest:
            self.missing[-1] = self.missing[-1].until(time)
        self.count += 1
        self.last = time if self.last is None else max(self.last, time)


def read_pieces(path: Path, take: Taker) -> Pieces:
    """Read a file to its end, or to where it was cut off; hand its messages over in blocks, so that few are held.

    What is damaged is passed over: `Pieces.missing` says what, and from when to when.

    Raises
    ------
    InputError
        It is not there, no MCAP file, or so damaged that nothing of it can be read.
    """
    try:
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise InputError(f"{path} is no MCAP recording; give a recording.mcap of a run")
            data = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)  # closes with the last view of it
            return _Taking(take).read(path, data)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"cannot read the recording {path}: {reason}; give a recording.mcap") from error


class _Taking:
    """One pass over a file."""

    def __init__(self, take: Taker) -> None:
        self._take = take
        self._pieces = Pieces()
        self._zero = 0
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, Stream | None] = {}

    def read(self, path: Path, data: mmap.mmap) -> Pieces:
        reader, pieces = Reader(data), self._pieces
        for stated in reader.summary:
            self._note(stated)
        for found in reader:
            if isinstance(found, Damage):
                pieces.lose(found.what, rest=found.rest)
            else:
                self._note(found)
        for stream in pieces.topics:
            self._hand_over(stream)
        pieces.whole = reader.whole
        if pieces.damaged and not (pieces.count or pieces.attachments or pieces.metadata):
            why = ", ".join(pieces.missing[0].reasons)
            raise InputError(f"{path} is damaged, and nothing in it can be read: {why}; record it again")
        return pieces

    def _note(self, record: Record) -> None:
        note = self._NOTES.get(record.code)
        if note is not None:
            try:
                note(self, record.body)
            except BROKEN as error:
                self._pieces.lose(f"a record that is not laid out as its kind is ({error})")

    def _schema(self, body: memoryview) -> None:
        (number,) = struct.unpack_from("<H", body)
        self._schemas[number] = text_at(body, 2)[0].replace("/msg/", "/")

    def _channel(self, body: memoryview) -> None:
        number, schema = struct.unpack_from("<HH", body)
        (topic, encoding), at = texts_at(body, 4, 2)
        words = pairs_at(body, at)
        stream = None
        if encoding == CDR:
            kind = self._schemas.get(schema, "")
            stream = Stream(topic, words.get("kind", ""), words.get("robot", ""), kind)
            self._pieces.topics.setdefault(stream, Messages())
        self._channels[number] = stream

    def _message(self, body: memoryview) -> None:
        channel, _, time, _ = MESSAGE_HEAD.unpack_from(body)
        if channel not in self._channels:
            self._pieces.lose("messages of a topic that was lost")
            return
        if time >= LATEST:
            raise ValueError("a time after the year 2262")
        stream = self._channels[channel]
        if stream is not None:
            self._pieces.reach((time - self._zero) / 1e9)
            messages = self._pieces.topics[stream]
            messages.add(time - self._zero, body[MESSAGE_HEAD.size :])
            if messages.size > BLOCK:
                self._hand_over(stream)

    def _attachment(self, body: memoryview) -> None:
        (name, _), at = texts_at(body, 16, 2)
        (length,) = struct.unpack_from("<Q", body, at)
        if at + 8 + length > len(body):
            raise ValueError("it ends within an attachment")
        self._pieces.attachments[name] = bytes(body[at + 8 : at + 8 + length])

    def _metadata(self, body: memoryview) -> None:
        name, at = text_at(body, 0)
        words = pairs_at(body, at)
        if name == CLOCK:
            self._zero = int(words.get(ZERO, "0"))
        else:
            self._pieces.metadata[name] = words

    def _hand_over(self, stream: Stream) -> None:
        messages = self._pieces.topics[stream]
        if len(messages):
            self._take(stream, messages)
            messages.clear()

    _NOTES = {
        SCHEMA: _schema,
        CHANNEL: _channel,
        MESSAGE: _message,
        ATTACHMENT: _attachment,
        METADATA: _metadata,
    }
