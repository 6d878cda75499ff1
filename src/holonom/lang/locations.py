"""Location files: taught locations by name, one in a line.

tray.small = 500, -200, 320, 0, 180, 0     ; x, y, z in mm; o, a, t in degrees (Z-Y-Z)
#ready     = 0, 90, -90, 0, 0, 0           ; joint values: degrees, or mm of a joint that slides
corner[2]  = 100, 0, 0, 0, 180, 0          ; an element of an array
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from holonom.errors import ProgramError
from holonom.files import check_lines
from holonom.lang import poses
from holonom.lang.compiler.syntax import WORDS
from holonom.lang.diagnostics import Diagnostic, Span
from holonom.lang.machine import Array
from holonom.lang.words.functions import FUNCTIONS

__all__ = ["read_locations", "split_name"]

_NAME = re.compile(r"#?[A-Za-z_][\w.]*(\[\s*[0-9]{1,5}(\s*,\s*[0-9]{1,5})*\s*\])?")
_NUMBER = re.compile(r"\s*[+-]?((\d++(?:\.\d*+)?|\.\d++)([eE][+-]?\d+)?|inf)\s*", re.ASCII)
_FORM = "write name = x, y, z, o, a, t in mm and degrees, or #name = j1, j2, ... in degrees (mm where a joint slides)"


def read_locations(text: str, file: str, turns: Sequence[bool] | None = None) -> dict[str, Array]:
    """Return the locations of a file's text by name, in lower case: poses (4, 4) in m, joints (n,) in rad or m.

    `turns` says of each joint of the arm whether it turns, and is told in degrees, or slides, and is told in mm; all
    turn unless it is given.

    Raises
    ------
    ProgramError
        At a line that is no location, with file, line, column, caret and hint.
    """
    check_lines(text, file)
    found: dict[str, Array] = {}
    for number, line in enumerate(text.split("\n"), start=1):
        content = line.partition(";")[0]
        if content.strip():
            name, value = _read_line(content, _Place(file, number, line), turns)
            if name in found:
                raise _Place(file, number, line).error(0, f"{name!r} is there twice", "remove one of the two")
            found[name] = value
    return found


def split_name(name: str) -> tuple[str, tuple[int, ...]]:
    """Return the name and the indices of `corner[2]`."""
    stem, _, indices = name.rstrip("]").partition("[")
    return stem, tuple(int(i) for i in indices.split(",")) if indices else ()


class _Place:
    """Where in a location file we are."""

    __slots__ = ("file", "line", "number")

    def __init__(self, file: str, number: int, line: str) -> None:
        self.file, self.number, self.line = file, number, line

    def error(self, column: int, text: str, hint: str, length: int = 1) -> ProgramError:
        """Return the error at a column, counted from 0."""
        span = Span(self.number, column + 1, column + 1 + length)
        return ProgramError(Diagnostic(self.file, span, text, hint, self.line).render())


def _read_line(content: str, place: _Place, turns: Sequence[bool] | None) -> tuple[str, Array]:
    head, equals, tail = content.partition("=")
    start = len(head) - len(head.lstrip())
    name = re.sub(r"\s", "", head).lower()
    if not equals:
        raise place.error(start, "this is no location", _FORM, len(content.strip()))
    if not _NAME.fullmatch(head.strip()):
        raise place.error(start, f"{head.strip()!r} is no name of a location", _FORM, len(head.strip()))
    stem = split_name(name)[0].upper()
    if stem in WORDS or stem in FUNCTIONS:
        raise place.error(start, f"{stem} is a word of the language", "choose another name", len(stem))
    values = _numbers(tail, len(head) + 1, place)
    if name.startswith("#"):
        return name, poses.precision_point(values, turns)
    if len(values) != 6:
        hint = "a location is x, y, z, o, a, t; joint values belong to a name that begins with #"
        raise place.error(len(head) + 1, f"a location has 6 values, this has {len(values)}", hint, len(tail))
    return name, poses.transformation(values)


def _numbers(tail: str, column: int, place: _Place) -> list[float]:
    values = []
    for part in tail.split(","):
        value = float(part) if _NUMBER.fullmatch(part) else math.nan
        if not abs(value) <= 1e6:
            lead, shown = len(part) - len(part.lstrip()), part.strip()
            what = f"{shown!r} is no number" if math.isnan(value) else f"{shown} is beyond 1e6 mm or degrees"
            raise place.error(column + lead, what, _FORM, max(1, len(shown)))
        values.append(value)
        column += len(part) + 1
    return values
