"""Numbers out of a CSV file, strictly: every fault with file, line and column."""

from __future__ import annotations

import io
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from holonom.arrays import Array
from holonom.errors import LogError
from holonom.files import check_lines, read_text

__all__ = ["Table", "read_table"]


NAME = re.compile(r"[\w .()\[\]/%*^-]{1,64}")
"""What columns may be called."""
SHOWN = 24
"""Characters of a cell that a message shows; no number has more."""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of numbers: `values` (N, k), their `names` (k,), where they came from, what is to be said of them."""

    path: Path
    names: tuple[str, ...]
    values: Array
    lines: Sequence[int]
    notes: tuple[str, ...] = ()

    def column(self, name: str) -> Array:
        """(N,) of a name that is there."""
        return self.values[:, self.names.index(name)]

    def cut(self, rows: Sequence[int]) -> list[Table]:
        """Tables of the rows before, between and from these on."""
        edges = [0, *(int(row) for row in rows), len(self.values)]
        return [Table(self.path, self.names, self.values[a:b], self.lines[a:b]) for a, b in itertools.pairwise(edges)]

    def fault(self, row: int, name: str, text: str) -> NoReturn:
        """Refuse the file because of one value.

        Raises
        ------
        LogError
        """
        column = self.names.index(name)
        raise LogError(f"{self.path}:{self.lines[row]}: column {column + 1} ({name}): {text}")


def read_table(path: Path, names: Sequence[str] | None = None) -> Table:
    """Read a CSV file of finite numbers, separated by commas.

    Parameters
    ----------
    path : the file, packed or not.
    names : of its columns if it has no header; otherwise they are its first line.

    Raises
    ------
    LogError
        File, line and column of what is no finite number, of rows that are too long or too short, an empty file.
    """
    text = read_text(path, "log", LogError)
    check_lines(text, path, LogError)
    lines = [number for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    body = text
    if names is None:
        if not lines:
            raise LogError(f"{path}:1: the file is empty; a header line and two samples or more are expected")
        header = text.splitlines()[lines[0] - 1]
        names, lines = [name.strip() for name in header.split(",")], lines[1:]
        body = "\n".join(text.splitlines()[lines[0] - 1 :]) if lines else ""
        _check_header(path, names)
    if len(lines) < 2:
        raise LogError(f"{path}:1: {len(lines)} samples; two or more are expected: the run was not recorded")
    values = _numbers(path, text, body, lines, names)
    table = Table(path, tuple(names), values, lines)
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, column = bad[0]
        table.fault(
            int(row), names[column], f"{values[row, column]} came; a finite number is expected: repair or cut it"
        )
    return table


def _check_header(path: Path, names: Sequence[str]) -> None:
    seen: set[str] = set()
    for column, name in enumerate(names, start=1):
        if not name or _is_number(name):
            raise LogError(f"{path}:1: column {column}: {name!r} is no name; the first line names the columns")
        if not NAME.fullmatch(name):  # perhaps another file: none of it is shown
            raise LogError(f"{path}:1: column {column} has no name of letters, digits and signs; is it a log?")
        if name in seen:
            raise LogError(f"{path}:1: column {column}: there are two columns {name!r}; name each once")
        seen.add(name)


def _numbers(path: Path, text: str, body: str, lines: Sequence[int], names: Sequence[str]) -> Array:
    try:
        values = np.loadtxt(io.StringIO(body), delimiter=",", ndmin=2, comments=None)
    except ValueError:
        _find_fault(path, text, lines, names)
    if values.shape != (len(lines), len(names)):
        _find_fault(path, text, lines, names)
    return values


def _find_fault(path: Path, text: str, lines: Sequence[int], names: Sequence[str]) -> NoReturn:
    rows = text.splitlines()
    for number in lines:
        cells = rows[number - 1].split(",")
        if len(cells) != len(names):
            raise LogError(f"{path}:{number}: {len(cells)} columns; {len(names)} are expected: {', '.join(names)}")
        for column, (cell, name) in enumerate(zip(cells, names, strict=True), start=1):
            if not _is_number(cell):
                came = cell.strip()
                shown = repr(came) if len(came) <= SHOWN else f"a text of {len(came)} characters"
                raise LogError(f"{path}:{number}: column {column} ({name}): {shown} is no number; repair or cut it")
    raise LogError(f"{path}: not a table of numbers; separate columns with commas, samples with line ends")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
