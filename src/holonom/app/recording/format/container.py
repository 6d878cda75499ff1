"""The records of an MCAP file, as far as they can be had: what is damaged is passed over, and said.

A record is believed where its checksum says so, or where it lies whole between sound ones. Behind one that cannot be
read the next one is sought that the file's index names, or a chunk, by the mark that those of a compression have. A
chunk that the file ends in is unpacked up to there. Source: MCAP 1.0 specification (mcap.dev/spec).
"""

from __future__ import annotations

import mmap
import struct
import zlib
from bisect import bisect_left
from collections.abc import Iterator
from typing import NamedTuple

import lz4.frame
import zstandard

__all__ = [
    "ATTACHMENT",
    "CHANNEL",
    "MAGIC",
    "MESSAGE",
    "MESSAGE_HEAD",
    "METADATA",
    "SCHEMA",
    "Damage",
    "Reader",
    "Record",
    "pairs_at",
    "text_at",
    "texts_at",
]

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
"""What every record begins with: what it is, and its length behind that."""
CHUNK = struct.Struct("<QQQI")
"""What a chunk begins with: first and last time, ns, size unpacked, checksum of that (0: none)."""
FOOTER = struct.Struct("<QQI")
"""Where the summary begins, where its index does, and the checksum of the summary (0: none)."""
MESSAGE_HEAD = struct.Struct("<HIQQ")
FOOTER_CODE, SCHEMA, CHANNEL, MESSAGE, CHUNK_CODE, ATTACHMENT, METADATA = 2, 3, 4, 5, 6, 9, 12
LAST_CODE, PRIVATE = 15, 0x80
"""Of the specification, and from where on others may have their own."""
INDEX = {8: 16, 10: 0, 13: 0}
"""Records of the summary that say where chunks, attachments and metadata begin, and where in them that stands."""
LARGEST_CHUNK = 256 * 2**20
"""Bytes of a chunk, unpacked; those of ROS 2 have less than one MiB."""
DENSITY = 2_000
"""Bytes out of one packed byte: more comes of a file that was made to fill memories."""
MARKS = (b"\x04\0\0\0zstd", b"\x03\0\0\0lz4")
"""How chunks say their compression, `CHUNK.size` behind their head."""


class Record(NamedTuple):
    """A record that is sound: what it is, and its body."""

    code: int
    body: memoryview


class Damage(NamedTuple):
    """Something that could not be read, in words; `rest`: nothing behind it can be, either."""

    what: str
    rest: bool = False


class Reader:
    """Goes through a file's bytes; `whole` is whether it came to the footer and the magic bytes behind it.

    `summary` are schemas and channels that the file repeats at its end, for when a chunk that states them is lost.
    """

    def __init__(self, data: mmap.mmap) -> None:
        self._data, self._search = memoryview(data), data
        self.whole = False
        self._places: tuple[int, ...] = ()
        self._data_end = len(self._data)
        self.summary = tuple(self._read_summary())

    def __iter__(self) -> Iterator[Record | Damage]:
        at, size = len(MAGIC), len(self._data)
        while True:
            if at >= self._data_end:  # the rest is the summary, which was read
                self.whole = self._data_end < size
                return
            code, length = HEAD.unpack_from(self._data, at) if at + HEAD.size <= size else (0, 0)
            start, end = at + HEAD.size, at + HEAD.size + length
            if code == FOOTER_CODE and length == FOOTER.size and bytes(self._data[end : end + len(MAGIC)]) == MAGIC:
                self.whole = True
                return
            known = 0 < code <= LAST_CODE or code >= PRIVATE
            if known and end <= size:
                found = list(self._record(code, start, end))
                yield from found
                sound = not any(isinstance(one, Damage) for one in found)
                after = end if sound else self._next_place(at + 1)
            else:
                after = self._next_place(at + 1)
                if after is not None:
                    yield Damage("a record that is none")
                elif code == CHUNK_CODE:
                    yield from _cut_chunk(self._data[start:])
                elif any(self._data[at:]):
                    yield Damage("it ends within a record" if known else "what is no record", rest=True)
            if after is None:
                return
            at = after

    def _record(self, code: int, start: int, end: int) -> Iterator[Record | Damage]:
        """The sound records of one: those of a chunk, or itself."""
        body = self._data[start:end]
        if code == CHUNK_CODE:
            yield from _chunk(body)
        elif code == ATTACHMENT and not _attachment_is_sound(body):
            yield Damage("an attachment whose checksum is wrong")
        elif code != ATTACHMENT and bytes(body[CHUNK.size :][: len(MARKS[0])]).startswith(MARKS):
            yield Damage("a chunk that says that it is none")
        elif code != ATTACHMENT and self._next_place(start, end) is not None:
            yield Damage("a record that reaches over others")
        else:
            yield Record(code, body)

    def _next_place(self, start: int, end: int | None = None) -> int | None:
        """Where the next thing begins, from a place on, that looks like a chunk or that the file's index names."""
        stop, before = self._data_end if end is None else end, HEAD.size + CHUNK.size
        found = []
        for mark in MARKS:
            at = self._search.find(mark, start + before, stop)
            while at >= 0 and self._data[at - before] != CHUNK_CODE:
                at = self._search.find(mark, at + 1, stop)
            if at >= 0:
                found.append(at - before)
        known = bisect_left(self._places, start)
        found += [place for place in self._places[known : known + 1] if end is None or place < end]
        return min(found, default=None)

    def _read_summary(self) -> Iterator[Record]:
        size, tail = len(self._data), FOOTER.size + len(MAGIC)
        if size < len(MAGIC) + HEAD.size + tail or bytes(self._data[-len(MAGIC) :]) != MAGIC:
            return
        foot = size - tail - HEAD.size
        begin, _, checksum = FOOTER.unpack_from(self._data, foot + HEAD.size)
        if self._data[foot] != FOOTER_CODE or not len(MAGIC) <= begin < foot:
            return
        if checksum and zlib.crc32(self._data[begin : size - len(MAGIC) - 4]) != checksum:
            return
        places, self._data_end = [foot], begin
        for record in _records(self._data[begin:foot]):
            if record.code in (SCHEMA, CHANNEL):
                yield record
            elif record.code in INDEX and len(record.body) >= 24:
                places.append(struct.unpack_from("<Q", record.body, INDEX[record.code])[0])
        self._places = tuple(place for place in sorted(places) if place <= foot)


def _chunk(body: memoryview) -> Iterator[Record | Damage]:
    """Records of a chunk that lies whole in the file."""
    try:
        _, _, size, checksum = CHUNK.unpack_from(body)
        kind, at = text_at(body, CHUNK.size)
        (length,) = struct.unpack_from("<Q", body, at)
        packed = body[at + 8 : at + 8 + length]
        if len(packed) != length or at + 8 + length != len(body):
            raise ValueError("its parts do not fit its length")
        data = _unpacked(kind, packed, size)
    except (struct.error, ValueError, zstandard.ZstdError, RuntimeError, EOFError, MemoryError) as error:
        yield Damage(f"a chunk ({' '.join(str(error).split()) or type(error).__name__})")
        return
    if checksum and zlib.crc32(data) != checksum:
        yield Damage("a chunk whose checksum is wrong")
        return
    yield from _records(memoryview(data))


def _cut_chunk(body: memoryview) -> Iterator[Record | Damage]:
    """What there is of the chunk that a file ends in; without its end no checksum vouches for it, but its times do."""
    found: list[Record] = []
    try:
        first, last, size, _ = CHUNK.unpack_from(body)
        kind, at = text_at(body, CHUNK.size)
        data = _begun(kind, bytes(body[at + 8 :]), min(size, LARGEST_CHUNK))
        for record in _records(memoryview(data)):
            if record.code == MESSAGE:
                _, _, time, _ = MESSAGE_HEAD.unpack_from(record.body)
                if not first <= time <= last:
                    break
            found.append(record)
    except (struct.error, ValueError, zstandard.ZstdError, RuntimeError, EOFError, MemoryError):
        pass  # nothing of it, then
    yield from found
    yield Damage("it ends within a chunk", rest=True)


def _unpacked(kind: str, packed: memoryview, size: int) -> bytes:
    """Unpack a chunk.

    Raises
    ------
    ValueError, ZstdError, RuntimeError
        It is too large, of another compression, or no such thing.
    """
    if size > LARGEST_CHUNK or size > DENSITY * (len(packed) + 1000):
        raise ValueError(
            f"it states {size} bytes; at most {LARGEST_CHUNK}, and {DENSITY} from each packed one, are read"
        )
    if kind == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(bytes(packed)) as stream:
            data = stream.read(size + 1)
    elif kind == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(bytes(packed), max_length=size + 1)
    elif kind == "":
        data = bytes(packed)
    else:
        raise ValueError(f"compression {kind[:20]!r}; zstd, lz4 and none are read")
    if len(data) != size:
        raise ValueError(f"it has {len(data)} bytes and states {size}")
    return data


def _begun(kind: str, packed: bytes, size: int) -> bytes:
    """As much of a chunk as its beginning holds."""
    if kind == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(packed) as stream:
            return stream.read(min(size, DENSITY * len(packed)))
    if kind == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size))
    return packed[:size] if kind == "" else b""


def _records(data: memoryview) -> Iterator[Record]:
    """Whole records in a stretch of bytes."""
    at, size = 0, len(data)
    while at + HEAD.size <= size:
        code, length = HEAD.unpack_from(data, at)
        at += HEAD.size
        if at + length > size:
            return
        yield Record(code, data[at : at + length])
        at += length


def _attachment_is_sound(body: memoryview) -> bool:
    if len(body) < 4:
        return False
    (checksum,) = struct.unpack_from("<I", body, len(body) - 4)
    return not checksum or zlib.crc32(body[:-4]) == checksum


def text_at(data: memoryview, at: int) -> tuple[str, int]:
    """Text, after its length, at a place, and where it ends.

    Raises
    ------
    ValueError
        It reaches beyond the end, or is no UTF-8.
    """
    (length,) = struct.unpack_from("<I", data, at)
    if at + 4 + length > len(data):
        raise ValueError("it ends within a text")
    return bytes(data[at + 4 : at + 4 + length]).decode(), at + 4 + length


def texts_at(data: memoryview, at: int, count: int) -> tuple[list[str], int]:
    """So many texts in a row, and where they end; raises as `text_at`."""
    found = []
    for _ in range(count):
        text, at = text_at(data, at)
        found.append(text)
    return found, at


def pairs_at(data: memoryview, at: int) -> dict[str, str]:
    """Texts by texts, after their length in bytes; raises as `text_at`."""
    (length,) = struct.unpack_from("<I", data, at)
    end, at = at + 4 + length, at + 4
    found = {}
    while at < min(end, len(data)):
        (key, value), at = texts_at(data, at, 2)
        found[key] = value
    return found
