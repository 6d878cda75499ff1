"""Common Data Representation, little endian, as ROS 2 writes its messages.

Strings of a message hardly ever change from one to the next, numbers always do. A `Layout` is a message with
its strings in place and its numbers open: filling it is two array assignments, whatever its size.
Source: OMG Common Object Request Broker Architecture 3.4, part 2, chapter 9.3 (CDR).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.errors import ShapeError

__all__ = ["ENCAPSULATION", "CdrReader", "CdrWriter", "Layout"]

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Four bytes before every message: CDR, little endian. Alignment counts from behind them."""

_SECOND = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Layout:
    """A message whose strings and counts are fixed; its time stamps and doubles are open.

    Attributes
    ----------
    template : (size,) uint8
        The message behind the encapsulation, open places zero, padded to whole doubles.
    size : int
        Bytes of the message without padding.
    stamps : (m,) int
        Where the time stamps lie, counted in 32-bit words.
    doubles : (k,) int
        Where the doubles lie, counted in doubles.
    """

    template: NDArray[np.uint8]
    size: int
    stamps: NDArray[np.intp]
    doubles: NDArray[np.intp]

    def pack(self, nanoseconds: int, values: NDArray[np.float64] | NDArray[np.int64]) -> bytes:
        """Message with all stamps at one time and `values`, any shape with k elements, in the open places.

        Whole numbers of 64 bits take the places of doubles.
        """
        if values.size != self.doubles.size:
            raise ShapeError(
                f"{values.size} numbers for a message that holds {self.doubles.size}; "
                "give one per joint or frame that the recorder was told of"
            )
        data = self.template.copy()
        words = data.view("<u4")
        words[self.stamps] = nanoseconds // _SECOND
        words[self.stamps + 1] = nanoseconds % _SECOND
        data.view(values.dtype)[self.doubles] = values.ravel()
        return ENCAPSULATION + data[: self.size].tobytes()

    def matches(self, rows: NDArray[np.uint8]) -> NDArray[np.bool_]:
        """Which of the messages, rows (N, size) without encapsulation, have this layout."""
        fixed = np.ones(self.template.size, dtype=np.bool_)
        fixed.reshape(-1, 4)[np.concatenate([self.stamps, self.stamps + 1])] = False
        fixed.reshape(-1, 8)[self.doubles] = False
        fixed = fixed[: self.size]
        same: NDArray[np.bool_] = (rows[:, fixed] == self.template[: self.size][fixed]).all(axis=1)
        return same

    def unpack(self, rows: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Open doubles (N, k) of messages of this layout, rows (N, size) without encapsulation."""
        padded = np.zeros((len(rows), self.template.size), dtype=np.uint8)
        padded[:, : self.size] = rows
        return padded.view("<f8")[:, self.doubles].astype(np.float64)


class CdrWriter:
    """Builds one message, value by value, each aligned to its own size."""

    __slots__ = ("_data", "_doubles", "_stamps")

    def __init__(self) -> None:
        self._data = bytearray()
        self._stamps: list[int] = []
        self._doubles: list[int] = []

    def byte(self, value: int) -> CdrWriter:
        """One byte: `bool`, `byte` or `uint8`."""
        self._data.append(value)
        return self

    def uint32(self, value: int) -> CdrWriter:
        """A 32-bit unsigned number, as counts are too."""
        self._align(4)
        self._data += struct.pack("<I", value)
        return self

    def float32(self, value: float) -> CdrWriter:
        """A number of 32 bits."""
        self._align(4)
        self._data += struct.pack("<f", value)
        return self

    def blob(self, value: bytes) -> CdrWriter:
        """Bytes, after their count."""
        self.uint32(len(value))
        self._data += value
        return self

    def text(self, value: str) -> CdrWriter:
        """A string: its length in bytes with the closing zero, then the bytes."""
        encoded = value.encode() + b"\0"
        self.uint32(len(encoded))
        self._data += encoded
        return self

    def stamp(self, nanoseconds: int = 0) -> CdrWriter:
        """A `builtin_interfaces/Time`; an open place of the layout."""
        self._align(4)
        self._stamps.append(len(self._data) // 4)
        return self.uint32(nanoseconds // _SECOND).uint32(nanoseconds % _SECOND)

    def doubles(self, count: int) -> CdrWriter:
        """`count` doubles in a row, open places of the layout."""
        if count:
            self._align(8)
            self._doubles += range(len(self._data) // 8, len(self._data) // 8 + count)
            self._data += bytes(8 * count)
        return self

    def message(self) -> bytes:
        """The message as it stands."""
        return ENCAPSULATION + bytes(self._data)

    def layout(self) -> Layout:
        """The message as a layout to fill."""
        padded = bytes(self._data) + bytes(-len(self._data) % 8)
        return Layout(
            template=np.frombuffer(padded, dtype=np.uint8),
            size=len(self._data),
            stamps=np.array(self._stamps, dtype=np.intp),
            doubles=np.array(self._doubles, dtype=np.intp),
        )

    def _align(self, size: int) -> None:
        self._data += bytes(-len(self._data) % size)


class CdrReader:
    """Walks through one message; the counterpart of `CdrWriter`. What reaches beyond its end is a `ValueError`."""

    __slots__ = ("_at", "_data")

    def __init__(self, message: bytes) -> None:
        self._data = message[len(ENCAPSULATION) :]
        self._at = 0

    def byte(self) -> int:
        """One byte."""
        return self._taken(1)[0]

    def uint32(self) -> int:
        """A 32-bit unsigned number."""
        self._align(4)
        return int.from_bytes(self._taken(4), "little")

    def text(self) -> str:
        """A string."""
        return self._taken(self.uint32())[:-1].decode()

    def stamp(self) -> int:
        """A time stamp in nanoseconds."""
        return self.uint32() * _SECOND + self.uint32()

    def blob(self) -> bytes:
        """Bytes, after their count."""
        return self._taken(self.uint32())

    def doubles(self, count: int) -> NDArray[np.float64]:
        """`count` doubles, (count,)."""
        self._align(8)
        return np.frombuffer(self._taken(8 * count), dtype="<f8", count=count)

    def skip_doubles(self, count: int) -> None:
        """Pass over `count` doubles."""
        if count:
            self._align(8)
            self._taken(8 * count)

    def _taken(self, size: int) -> bytes:
        self._at += size
        if self._at > len(self._data):
            raise ValueError(f"it has {len(self._data)} bytes and says that it has {self._at} or more")
        return self._data[self._at - size : self._at]

    def _align(self, size: int) -> None:
        self._at += -self._at % size
