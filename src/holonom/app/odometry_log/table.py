"""Numbers out of a CSV file, strictly: every fault with file, line and column."""

from __future__ import annotations

import csv
import dataclasses
import io
import itertools
import re
from collections.abc import Container, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from holonom.arrays import Array
from holonom.errors import LogError
from holonom.files import check_lines, decimal, read_text

__all__ = ["Table", "read_table"]


NAME = re.compile(r"[\w .()\[\]/%*^-]{1,64}")
"""What columns may be called."""
QUOTED = re.compile(r'"[^"]*"')
SHOWN = 24
"""Characters of a cell that a message shows; no number has more."""


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of numbers: `values` (N, k), their `names` (k,), the file, lines and columns they came from.

    `ignored` are the names of columns that were not read.
    """

    path: Path
    names: tuple[str, ...]
    values: Array
    lines: Sequence[int]
    columns: tuple[int, ...] = ()
    ignored: tuple[str, ...] = ()

    def column(self, name: str) -> Array:
        """(N,) of a name that is there."""
        return self.values[:, self.names.index(name)]

    def cut(self, rows: Sequence[int]) -> list[Table]:
        """Tables of the rows before, between and from these on."""
        edges = [0, *(int(row) for row in rows), len(self.values)]
        return [
            dataclasses.replace(self, values=self.values[a:b], lines=self.lines[a:b])
            for a, b in itertools.pairwise(edges)
        ]

    def fault(self, row: int, name: str, text: str) -> NoReturn:
        """Refuse the file because of one value.

        Raises
        ------
        LogError
        """
        raise LogError(f"{self.path}:{self.lines[row]}: column {self.place(name)} ({name}): {text}")

    def place(self, name: str) -> int:
        """Number of a column in its file, from 1 on."""
        at = self.names.index(name)
        return self.columns[at] if self.columns else at + 1


def read_table(
    path: Path, names: Sequence[str] | None = None, *, needed: Container[str] | None = None,
    sparse: Container[str] = (),
) -> Table:  # fmt: skip
    """Read a CSV file of finite numbers, separated by commas, semicolons or tabs.

    Parameters
    ----------
    path : the file, packed or not. With semicolons or tabs numbers may have decimal commas.
    names : of its columns if it has no header; otherwise they are its first line.
    needed : columns that are read; of others numbers and words may be anything. None: all.
    sparse : columns that may be empty where they were not sampled; NaN then.

    Raises
    ------
    LogError
        File, line and column of what is no finite number, of rows that are too long or too short, an empty file.
    """
    text = read_text(path, "log", LogError)
    check_lines(text, path, LogError)
    rows = text.split("\n")
    lines = [number for number, line in enumerate(rows, start=1) if line.strip()]
    if not lines and names is None:
        raise LogError(f"{path}:1: the file is empty; a header line and two samples or more are expected")
    mark = _separator(rows[lines[0] - 1]) if lines else ","
    if names is None:
        names, lines = [name.strip() for name in _cells(path, lines[0], rows[lines[0] - 1], mark)], lines[1:]
        _check_header(path, names)
    if len(lines) < 2:
        count = "1 sample" if lines else "0 samples"
        raise LogError(f"{path}:1: {count}; two or more are expected: the run was not recorded")
    kept = [k for k, name in enumerate(names) if needed is None or name in needed]
    may = [names[k] in sparse for k in kept]
    values = _numbers(path, rows, lines, names, kept, may, mark)
    ignored = tuple(name for k, name in enumerate(names) if k not in kept)
    table = Table(path, tuple(names[k] for k in kept), values, lines, tuple(k + 1 for k in kept), ignored)
    bad = np.argwhere(~np.isfinite(values) & ~(np.isnan(values) & np.array(may, dtype=bool)))
    if len(bad):
        row, column = bad[0]
        table.fault(
            int(row), table.names[column],
            f"{values[row, column]} came; a finite number is expected: repair or cut it",
        )  # fmt: skip
    return table


def _separator(line: str) -> str:
    """What stands between the cells of a line: a semicolon or a tab where there is one, else a comma."""
    bare = QUOTED.sub("", line)
    return next((mark for mark in (";", "\t") if mark in bare), ",")


def _cells(path: Path, number: int, line: str, mark: str) -> list[str]:
    """The cells of a line; in quotes as RFC 4180 has them, but for line breaks."""
    if '"' not in line:
        return line.split(mark)
    try:
        return next(csv.reader([line], delimiter=mark, skipinitialspace=True, strict=True))
    except csv.Error:
        raise LogError(
            f"{path}:{number}: quotes that do not enclose a cell of this line; repair or leave them out"
        ) from None


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


def _numbers(
    path: Path, rows: Sequence[str], lines: Sequence[int], names: Sequence[str], kept: Sequence[int],
    may: Sequence[bool], mark: str,
) -> Array:  # fmt: skip
    """Columns that are kept; where all cells of a file are numbers, by the quickest way."""
    if len(kept) == len(names) and not any(may):
        body = "\n".join(rows[number - 1] for number in lines)
        try:
            values = np.loadtxt(io.StringIO(body), delimiter=mark, ndmin=2, comments=None)
        except ValueError:
            values = np.empty((0, 0))
        if values.shape == (len(lines), len(names)):
            return values
    values = np.empty((len(lines), len(kept)))
    for k, number in enumerate(lines):
        cells = _cells(path, number, rows[number - 1], mark)
        if len(cells) != len(names):
            raise LogError(f"{path}:{number}: {len(cells)} columns; {len(names)} are expected: {', '.join(names)}")
        for j, column in enumerate(kept):
            values[k, j] = _number(path, number, column, names[column], cells[column], mark, empty=may[j])
    return values


def _number(path: Path, line: int, column: int, name: str, cell: str, mark: str, *, empty: bool) -> float:
    text = cell.strip()
    if empty and text == "":
        return float("nan")
    text = text.replace(",", ".") if mark != "," and text.count(",") == 1 else text
    try:
        return decimal(text)
    except ValueError:
        came = cell.strip()
        shown = repr(came) if len(came) <= SHOWN else f"a text of {len(came)} characters"
        raise LogError(f"{path}:{line}: column {column + 1} ({name}): {shown} is no number; repair or cut it") from None


def _is_number(text: str) -> bool:
    try:
        decimal(text)
    except ValueError:
        return False
    return True
