"""The records of an MCAP file, whole or cut off: messages by topic, attachments and metadata."""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Footer, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from zstandard import ZstdError

from holonom.app.recording.format.topic_messages import Messages
from holonom.errors import InputError

__all__ = ["Pieces", "Stream", "Taker", "read_pieces"]

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
"""What every record begins with: what it is, and its length behind that."""
MESSAGE = struct.Struct("<HIQQ")
"""What a message begins with: channel, sequence, when it was logged and published."""
BLOCK = 8_000_000
"""Bytes of one topic that are held before they are made into arrays: an hour of messages is ten times its arrays."""
CDR = "cdr"
DAMAGED = (McapError, ZstdError, struct.error, ValueError, KeyError, IndexError)
"""What broken records raise in reading."""


class Stream(NamedTuple):
    """What a file says of a channel; kind and robot are "" in files that say none."""

    topic: str
    kind: str
    robot: str


@dataclass(slots=True)
class Pieces:
    """What is in a file: messages that were not taken yet, how many were, up to when; `whole` unless it is cut off."""

    topics: dict[Stream, Messages] = field(default_factory=dict)
    count: int = 0
    last: float = 0.0
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    whole: bool = True

    def story(self) -> str:
        """How much there is, in words."""
        count = self.count + sum(map(len, self.topics.values()))
        last = max((messages.last() for messages in self.topics.values() if len(messages)), default=0.0)
        return f"{count} messages, to {max(last, self.last):g} s,"


Taker = Callable[[Stream, Messages], None]
"""What takes the messages of a topic, some at a time, in their order."""


def read_pieces(path: Path, take: Taker) -> Pieces:
    """Read a file to its end, or to where it was cut off; hand its messages over in blocks, so that few are held.

    Raises
    ------
    InputError
        It is missing, no MCAP file, or damaged before its end.
    """
    pieces, channels = Pieces(), dict[int, Stream]()
    try:
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise InputError(f"{path} is no MCAP recording; give a recording.mcap of a run")
            end, pieces.whole = _whole_part(stream)
            for record in _records(stream, end):
                _take(record, pieces, channels, take)
            for topic in pieces.topics:
                _hand_over(topic, pieces, take)
    except OSError as error:
        raise InputError(f"cannot read the recording {path}: {error.strerror}; give a recording.mcap") from error
    except InputError:
        raise
    except DAMAGED as error:
        reason = str(error) or type(error).__name__
        raise InputError(
            f"{path} is damaged ({reason}); {pieces.story()} before that are sound: record it again"
        ) from error
    return pieces


def _whole_part(stream: IO[bytes]) -> tuple[int, bool]:
    """Where the last whole record ends, and whether that is the file's own end; the stream stays where it was."""
    start, size = stream.tell(), os.fstat(stream.fileno()).st_size
    at = start
    while True:
        stream.seek(at)
        head = stream.read(HEAD.size)
        opcode, length = HEAD.unpack(head) if len(head) == HEAD.size else (0, 0)
        after = at + HEAD.size + length
        if opcode == 0 or (opcode > max(Opcode) and opcode < 0x80) or after > size:
            break
        at = after
        if opcode == Opcode.FOOTER:
            break
    stream.seek(at)
    whole = opcode == Opcode.FOOTER and stream.read(len(MAGIC)) == MAGIC
    stream.seek(start)
    return at, whole


def _records(stream: IO[bytes], end: int) -> Iterator[McapRecord]:
    records = iter(StreamReader(stream, skip_magic=True, emit_chunks=True).records)
    while stream.tell() < end:
        record = next(records)
        if isinstance(record, Chunk):
            yield from _broken_up(record)
        elif isinstance(record, Footer):
            return
        else:
            yield record


def _broken_up(chunk: Chunk) -> Iterator[McapRecord]:
    """Records of a chunk; the library's own way takes ten times as long."""
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    data, at = memoryview(stream.read(length)), 0
    while at < length:
        opcode, size = HEAD.unpack_from(data, at)
        at += HEAD.size
        if opcode == Opcode.MESSAGE:
            channel, sequence, log_time, publish_time = MESSAGE.unpack_from(data, at)
            body = data[at + MESSAGE.size : at + size]
            yield Message(channel, log_time, body, publish_time, sequence)  # type: ignore[arg-type]
        elif opcode == Opcode.CHANNEL:
            yield Channel.read(ReadDataStream(BytesIO(data[at : at + size])))
        at += size


def _take(record: McapRecord, pieces: Pieces, channels: dict[int, Stream], take: Taker) -> None:
    if isinstance(record, Message):
        stream = channels.get(record.channel_id)
        if stream is not None:
            messages = pieces.topics[stream]
            messages.add(record.log_time, record.data)
            if messages.size > BLOCK:
                _hand_over(stream, pieces, take)
    elif isinstance(record, Channel):
        if record.message_encoding == CDR:
            stream = Stream(record.topic, record.metadata.get("kind", ""), record.metadata.get("robot", ""))
            channels[record.id] = stream
            pieces.topics.setdefault(stream, Messages())
    elif isinstance(record, Attachment):
        pieces.attachments[record.name] = record.data
    elif isinstance(record, Metadata):
        pieces.metadata[record.name] = dict(record.metadata)


def _hand_over(stream: Stream, pieces: Pieces, take: Taker) -> None:
    messages = pieces.topics[stream]
    if len(messages):
        take(stream, messages)
        pieces.count += len(messages)
        pieces.last = max(pieces.last, messages.last())
        messages.clear()
