"""The messages of one topic, end to end in one stretch of bytes: an hour of a run is millions of them."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["Messages", "Stream"]


class Stream(NamedTuple):
    """What a file says of a channel; kind and robot are "" in files that say none, `type` is that of its messages."""

    topic: str
    kind: str
    robot: str
    type: str = ""


class Messages:
    """Messages in the order of the file, with their times, ns."""

    __slots__ = ("_data", "_sizes", "_times")

    def __init__(self) -> None:
        self._data = bytearray()
        self._sizes, self._times = array("q"), array("q")

    def add(self, time: int, message: bytes | memoryview) -> None:
        """Take one more."""
        self._times.append(time)
        self._sizes.append(len(message))
        self._data += message

    def __len__(self) -> int:
        return len(self._times)

    def __iter__(self) -> Iterator[bytes]:
        start = 0
        for size in self._sizes:
            yield bytes(self._data[start : start + size])
            start += size

    def last(self) -> float:
        """Time of the last one, s."""
        return self._times[-1] / 1e9

    @property
    def size(self) -> int:
        """Bytes of all of them."""
        return len(self._data)

    def clear(self) -> None:
        """Forget them."""
        self._data = bytearray()
        self._sizes, self._times = array("q"), array("q")

    def halves(self) -> tuple[Messages, Messages]:
        """The first and the second half of them."""
        parts = Messages(), Messages()
        for k, (time, message) in enumerate(zip(self._times, self, strict=True)):
            parts[2 * k >= len(self)].add(time, message)
        return parts

    def seconds(self) -> NDArray[np.float64]:
        """Times (N,), s."""
        return np.array(self._times, dtype=np.int64) / 1e9

    def lengths(self) -> NDArray[np.int64]:
        """Bytes (N,) of each."""
        return np.array(self._sizes, dtype=np.int64)

    def message(self, k: int) -> bytes:
        """One of them."""
        sizes = self.lengths()
        start = int(sizes[:k].sum())
        return bytes(self._data[start : start + int(sizes[k])])

    def rows(self, at: NDArray[np.intp], size: int) -> NDArray[np.uint8]:
        """Those at some places, which have one size, as rows (k, size)."""
        data = np.frombuffer(bytes(self._data), dtype=np.uint8)
        if len(at) == len(self):
            return data.reshape(len(self), size)
        starts = np.concatenate([[0], np.cumsum(self.lengths())[:-1]])
        return data[starts[at][:, None] + np.arange(size)]
