"""A file that grows by whole pieces: what is flushed survives the process, and a full disk leaves no torn piece."""

from __future__ import annotations

import os
from pathlib import Path

from holonom.errors import OutputError, OutputFault

__all__ = ["GrowingFile"]


class GrowingFile:
    """What `mcap.writer.Writer` needs of a stream; `flush` hands everything since the last one over in one write.

    Raises
    ------
    OutputError
        The file cannot be made.
    """

    __slots__ = ("_file", "_path", "_size", "_waiting", "failed")

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file = open(path, "wb", buffering=0)  # noqa: SIM115  (closed in `close`)
        except OSError as error:
            raise OutputError(
                f"cannot write the recording {path}: {error.strerror}; give a folder that can be written"
            ) from error
        self._waiting = bytearray()
        self._size = 0
        self.failed = False

    def tell(self) -> int:
        """Length of the file once everything is flushed."""
        return self._size + len(self._waiting)

    def write(self, data: bytes) -> int:
        """Take bytes."""
        self._waiting += data
        return len(data)

    def flush(self) -> None:
        """Hand over what waits to the operating system.

        Raises
        ------
        OutputFault
            The disk is full, or gone. The file ends with the last whole piece, and takes nothing more.
        """
        try:
            left = memoryview(bytes(self._waiting))
            while len(left):
                left = left[self._file.write(left) :]
        except OSError as error:
            self.failed = True
            self._cut_back()
            raise OutputFault(
                f"cannot write the recording {self._path} any further: {error.strerror}; what was recorded until then "
                "is kept: make room, or give another folder with -o"
            ) from error
        self._size += len(self._waiting)
        self._waiting.clear()

    @property
    def closed(self) -> bool:
        """Whether it is closed."""
        return self._file.closed

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _cut_back(self) -> None:
        self._waiting.clear()
        try:
            os.ftruncate(self._file.fileno(), self._size)
        except OSError:
            return  # a piece that is torn is passed over in reading
