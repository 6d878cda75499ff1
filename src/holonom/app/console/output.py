"""The folder that a command writes to: checked before anything else happens, and one run's alone while it writes."""

from __future__ import annotations

import errno
import fcntl
import os
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from holonom.errors import OutputError, OutputFault

__all__ = ["RECORDING", "REPORT", "SUMMARY", "RunFolder", "prepare_output"]

RECORDING, SUMMARY, REPORT = "recording.mcap", "summary.json", "report.html"
"""What a run leaves."""
LOCK = ".lock"

CLOSED = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC)
"""What the system says of a folder that is there but takes nothing."""


def prepare_output(folder: str | Path) -> Path:
    """Make a folder and see that files can be written to it; nothing is left in it.

    Raises
    ------
    OutputError
        It cannot be made: something else has its name.
    OutputFault
        It is read-only, or the disk is full.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError as error:
        reason = error.strerror or str(error)
        kind = OutputFault if error.errno in CLOSED else OutputError
        raise kind(f"cannot write to the output folder {path}: {reason}; give another one with -o") from None


class RunFolder:
    """A folder that one run writes to; use it as a context manager.

    While it is open no other run gets in; a killed one leaves nothing that bars it. What a finished run left is removed
    at the start, so that the recording has its name from its first record on, and grows; everything else in the folder
    stays. Summary and report appear whole or not at all.

    Parameters
    ----------
    folder
        Made if need be.
    recordings
        Names of recordings that a run leaves.
    keep
        Remove nothing at the start: what is written is not a run's.

    Raises
    ------
    OutputError
        In entering: the folder cannot be made, or another run writes to it; which.
    OutputFault
        In entering: the folder is read-only, or the disk is full.
    """

    __slots__ = ("_lock", "_old", "path")

    def __init__(self, folder: str | Path, *, recordings: Sequence[str] = (RECORDING,), keep: bool = False) -> None:
        self.path = Path(folder)
        self._old = () if keep else (*recordings, SUMMARY, REPORT)
        self._lock: IO[str] | None = None

    def __enter__(self) -> Self:
        prepare_output(self.path)
        try:
            self._lock = _locked(self.path / LOCK)
            for name in self._old:
                if (self.path / name).is_file():
                    (self.path / name).unlink()
        except OSError as error:
            self._release()
            raise OutputError(
                f"cannot begin in the output folder {self.path}: {error.filename or LOCK}: {error.strerror}; give "
                "another one with -o"
            ) from None
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._release()

    def write(self, name: str, content: str | bytes) -> Path:
        """Write a file under another name, then give it its own.

        Raises
        ------
        OutputFault
            The disk is full or gone, or a folder has that name; the file is not there, others are as they were.
        """
        path, part = self.path / name, self.path / f".{name}.part"
        try:
            part.write_bytes(content.encode() if isinstance(content, str) else content)
            os.replace(part, path)
        except OSError as error:
            with suppress(OSError):
                part.unlink()
            raise OutputFault(
                f"cannot write {path}: {error.strerror}; what was recorded is in {self.path}: make room, or give "
                "another folder with -o"
            ) from None
        return path

    def _release(self) -> None:
        """Unlock. The file goes first: who waits for it sees that it is another one then."""
        if self._lock is not None:
            with suppress(OSError):
                (self.path / LOCK).unlink()
            self._lock.close()
            self._lock = None


def _locked(path: Path) -> IO[str]:
    """The lock's file, locked, with who holds it."""
    while True:
        file = open(path, "a+", encoding="utf-8")  # noqa: SIM115  (closed in `RunFolder._release`)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.seek(0)
            holder = file.read().strip() or "another run"
            file.close()
            raise OutputError(
                f"{holder} writes to the output folder {path.parent}; wait for its end, or give another folder with -o"
            ) from None
        if path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat()):
            break
        file.close()
    try:
        file.truncate(0)
        file.write(f"the run of process {os.getpid()}, begun {datetime.now().astimezone():%Y-%m-%d %H:%M:%S},")
        file.flush()
    except OSError:  # the disk is full
        path.unlink()
        with suppress(OSError):
            file.close()
        raise
    return file
