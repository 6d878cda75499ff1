"""Files that users name, never read beyond a stated size: as bytes, or as text, with or without a byte order mark.

`LIMITS` says how much of each kind is read; `docs/files.md` lists it.
"""

from __future__ import annotations

import gzip
import io
import stat
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from holonom.errors import InputError, ProgramError

__all__ = [
    "DIGITS",
    "LIMITS",
    "LINES",
    "LINE_LENGTH",
    "NESTING",
    "Kind",
    "check_lines",
    "decimal",
    "is_file",
    "is_inside",
    "read_bytes",
    "read_text",
]

MIB = 1 << 20
NESTING = 100
"""How deep tables, brackets, blocks and elements may stand in each other."""
DIGITS = 300
"""Characters of a number or a bare name: a double has no more than 309 digits before its point."""
LINES = 2_000_000
"""Lines of a table of numbers."""
LINE_LENGTH = 20_000
"""Characters of a line of a program, of locations or of a table."""


@dataclass(frozen=True, slots=True)
class Kind:
    """What a file is, for messages, and how many bytes of it are read; of a packed one, unpacked ones."""

    title: str
    most: int


LIMITS: Mapping[str, Kind] = MappingProxyType({
    "cell": Kind("a cell file (TOML)", MIB),
    "program": Kind("an ARPS program", MIB),
    "locations": Kind("a location file", 4 * MIB),
    "layout": Kind("a layout of parts (CSV)", 4 * MIB),
    "photograph": Kind("a photograph", 64 * MIB),
    "robot": Kind("a robot description (URDF or xacro)", 16 * MIB),
    "sheet": Kind("a process or an axis (TOML)", MIB),
    "description": Kind("the description of a log (TOML)", MIB),
    "drive": Kind("a file of a motor, an axis or a load cycle (TOML)", MIB),
    "log": Kind("a log (CSV)", 128 * MIB),
})  # fmt: skip
"""The kinds of files, by name."""


def read_bytes(path: str | Path, kind: str, problem: type[InputError]) -> bytes:
    """Read a file; one whose name ends in .gz unpacked.

    Raises
    ------
    InputError
        Of the type `problem`: it is not there, no file, larger than its kind may be, or cannot be unpacked.
    """
    path, what = Path(path), LIMITS[kind]
    reason, raw = "it is no file but a device or pipe", b""
    try:
        if stat.S_ISREG(path.stat().st_mode):
            with path.open("rb") as file:
                reason, raw = "", file.read(what.most + 1)
            if path.suffix == ".gz" and len(raw) <= what.most:
                raw = gzip.GzipFile(fileobj=io.BytesIO(raw)).read(what.most + 1)
        elif path.is_dir():
            reason = "Is a directory"
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        raise problem(f"{path}: cannot be read: no gzip file, or damaged ({error}); give another copy") from None
    except (OSError, ValueError) as error:  # a name with a zero byte is a ValueError
        reason = getattr(error, "strerror", None) or str(error)
    if reason:
        raise problem(f"{path}: cannot be read: {reason}; give the path of {what.title}")
    if len(raw) > what.most:
        raise problem(f"{path}: more than {what.most / MIB:g} MiB; {what.title} holds no more: split it")
    return raw


def read_text(path: str | Path, kind: str, problem: type[InputError]) -> str:
    """Read a text in UTF-8, without the byte order mark that it may begin with; line ends become "\\n".

    Raises
    ------
    InputError
        Of the type `problem`: as `read_bytes`, or no UTF-8 from some line on, or a zero character.
    """
    raw = read_bytes(path, kind, problem)
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise problem(f"{path}:{line}: not UTF-8 text; save the file as UTF-8") from None
    if (at := text.find("\0")) >= 0:
        line = text.count("\n", 0, at) + 1
        raise problem(f"{path}:{line}: a character of number 0, which no text has; give another copy, in UTF-8")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def check_lines(text: str, file: str | Path, problem: type[InputError] = ProgramError, *, most: int = LINES) -> None:
    """Raise `problem` at a line that is longer than `LINE_LENGTH`, or behind which there are more than `most` lines."""
    if text.count("\n") > most:
        raise problem(f"{file}:{most + 1}: more than {most} lines; split the file")
    if len(text) <= LINE_LENGTH:
        return
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > LINE_LENGTH:
            raise problem(
                f"{file}:{number}: {len(line)} characters in a line; at most {LINE_LENGTH} are read: split it"
            )


def decimal(text: str) -> float:
    """Return the number that a text of ASCII digits writes, spaces around it; such as "inf", too.

    Raises
    ------
    ValueError
        It writes none. Python's own reading takes 1_0 for ten, and the digits of every script.
    """
    if "_" in text or not text.isascii():
        raise ValueError(f"{text!r} is no number")
    return float(text)


def is_file(path: str | Path) -> bool:
    """Whether a file is there; not of a name that no system takes."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def is_inside(path: str | Path, folder: str | Path) -> bool:
    """Whether a file lies in a folder or below it, once every link is followed."""
    try:
        return Path(path).resolve().is_relative_to(Path(folder).resolve())
    except (OSError, RuntimeError, ValueError):  # links in a circle, a name that no system takes
        return False
