"""Machine code on disk, in one folder for all processes: an entry is one file, whose name says all that it depends on.

An entry is whole or not there: a file is written under another name first, and begins with its own hash. Two processes
do not make the same one: the second waits. What was used longest ago goes first when the folder gets too large, but
nothing that a running process holds. Where the folder cannot be read or written, the process says so once.

Locks are those of single bytes of one file, an entry's hash says which: they need no files of their own, end with
their process, and the system refuses the one that would wait for itself.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import re
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from holonom.errors import InputError, OutputError

try:
    import fcntl
except ImportError:  # Windows: without locks the same may be compiled twice
    fcntl = None  # type: ignore[assignment]

__all__ = ["CacheUse", "Entry", "cache_folder", "cache_limit", "cache_use", "empty_cache", "say"]

SUFFIX = ".kernel"
BEGAN = time.time()
"""From then on, a module in memory may be older than its file, and this process may use a kernel."""
UNITS = {"": 1, "K": 2**10, "M": 2**20, "G": 2**30}


class CacheUse(NamedTuple):
    """What the kernel cache holds."""

    folder: Path
    kernels: int
    size: int
    """Bytes."""
    limit: int
    """Bytes."""


def cache_folder() -> Path:
    """Return the folder of compiled kernels: `HOLONOM_CACHE`, else the user's cache folder."""
    named = os.environ.get("HOLONOM_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or (Path.home() / ".cache")
    return Path(named) if named else Path(base) / "holonom"


def cache_limit() -> int:
    """Return the size in bytes that the folder is kept below: `HOLONOM_CACHE_LIMIT`, such as 500M or 2G, else 1G.

    Raises
    ------
    InputError
        The variable is something else.
    """
    given = os.environ.get("HOLONOM_CACHE_LIMIT") or "1G"
    found = re.fullmatch(r"(\d+)([KMG]?)", given)
    if found is None:
        raise InputError(f"HOLONOM_CACHE_LIMIT is {given!r}; bytes, or a number with K, M or G, are needed: 500M")
    return int(found[1]) * UNITS[found[2]]


def cache_use() -> CacheUse:
    """Return how full the cache is; the folder need not exist."""
    files = _files(cache_folder())
    kernels = sum(path.suffix == SUFFIX for path, _ in files)
    return CacheUse(cache_folder(), kernels, sum(status.st_size for _, status in files), cache_limit())


def empty_cache() -> CacheUse:
    """Remove every kernel, and return what there was; running processes keep theirs in memory.

    Raises
    ------
    OutputError
        The folder cannot be written.
    """
    before = cache_use()
    for path, _ in _files(before.folder):
        try:
            path.unlink(missing_ok=True)
        except OSError as problem:
            raise OutputError(f"{path} cannot be removed ({problem.strerror}); make its folder writable") from problem
    return before


def say(text: str) -> None:
    """Print a line about the cache, one in a process: what follows has the same reason, or matters less."""
    if next(_once(), False):
        print(f"holonom: kernel cache: {text}", file=sys.stderr)


@functools.cache
def _once() -> Iterator[bool]:
    return iter([True])


class Entry:
    """The place of one kernel in the cache.

    Parameters
    ----------
    title : for people, the first part of the file's name.
    key : hexadecimal digits of the hash of everything that the kernel depends on.
    """

    def __init__(self, title: str, key: str) -> None:
        self.folder = cache_folder()
        self.path = self.folder / f"{title[:80]}-{key}{SUFFIX}"

    def read(self) -> bytes | None:
        """What was written, held until the process ends; None if there is none, or no whole one."""
        try:
            data = self.path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as problem:
            say(f"{self.path} cannot be read ({problem.strerror}): compiled anew; set HOLONOM_CACHE to another folder")
            return None
        if hashlib.sha256(memoryview(data)[32:]).digest() != data[:32]:
            self.say_damaged()
            return None
        with contextlib.suppress(OSError):  # when it was last used; where that cannot be written, nothing is removed
            os.utime(self.path, ns=(time.time_ns(), self.path.stat().st_mtime_ns))
        self._hold()
        return data[32:]

    def say_damaged(self) -> None:
        """Say that what was read is no kernel."""
        say(f"{self.path.name} was damaged: compiled anew and replaced; if this comes again, look at the disk")

    def write(self, data: bytes) -> None:
        """Write a file so that another process sees all of it or nothing, and keep the folder below its limit."""
        temporary = self.path.with_name(f"{self.path.name}.{uuid.uuid4().hex[:8]}")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            temporary.write_bytes(hashlib.sha256(data).digest() + data)
            os.replace(temporary, self.path)
        except OSError as problem:
            with contextlib.suppress(OSError):
                temporary.unlink()
            say(
                f"{self.folder} cannot be written ({problem.strerror}): each process compiles anew; make room there, "
                "or set HOLONOM_CACHE to a folder that can be written"
            )
            return
        self._hold()
        _shrink(self.folder)

    def lock(self) -> None:
        """Wait until no other process makes this entry; not where locks cannot be had."""
        _lock(self.folder, _place(self.path))

    def unlock(self) -> None:
        """Let the next process make it, or find it."""
        _unlock(self.folder, _place(self.path))

    def _hold(self) -> None:
        _lock(self.folder, _place(self.path) + 1, shared=True)


def _place(path: Path) -> int:
    """The byte that stands for making an entry; the next one stands for using it."""
    return 2 * int(path.name.removesuffix(SUFFIX).rpartition("-")[2][:15], 16)


@functools.cache
def _locks(folder: Path) -> int | None:
    """The file whose bytes are locked, open until the process ends: closing it would end all locks."""
    if fcntl is None:
        return None
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        return os.open(folder / "lock", os.O_RDWR | os.O_CREAT, 0o666)
    return None


def _lock(folder: Path, place: int, *, shared: bool = False, wait: bool = True) -> bool:
    """Whether nobody else has the byte; a lock that cannot be had for other reasons does not count."""
    file = _locks(folder)
    if file is None:
        return True
    try:
        fcntl.lockf(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB), 1, place)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:  # two that wait for each other, or a file system without locks: compiled twice, at worst
        return True
    return True


def _unlock(folder: Path, place: int) -> None:
    file = _locks(folder)
    if file is not None:
        with contextlib.suppress(OSError):
            fcntl.lockf(file, fcntl.LOCK_UN, 1, place)


def _files(folder: Path) -> list[tuple[Path, os.stat_result]]:
    """Our files, also those that a killed process left; those that vanish meanwhile are none."""
    found = []
    for path in folder.glob(f"*{SUFFIX}*"):
        with contextlib.suppress(OSError):
            found.append((path, path.stat()))
    return found


def _shrink(folder: Path) -> None:
    """Remove what was used longest ago, until the rest is below the limit or in use."""
    files = _files(folder)
    excess = sum(status.st_size for _, status in files) - cache_limit()
    for path, status in sorted(files, key=lambda file: file[1].st_atime) if excess > 0 else ():
        if excess <= 0 or status.st_atime >= BEGAN:  # this process may have used it
            break
        if _unused(path):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
                excess -= status.st_size


def _unused(path: Path) -> bool:
    if path.suffix != SUFFIX:  # half a file
        return True
    place = _place(path) + 1
    free = _lock(path.parent, place, wait=False)
    if free:
        _unlock(path.parent, place)
    return free
