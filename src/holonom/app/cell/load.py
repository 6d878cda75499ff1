"""Reading a cell file: TOML to a checked `Cell`, or one error that names file, line and key of all that is wrong."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.short import Misplaced, Written, written_out
from holonom.app.fields.toml_faults import line_of, parse_toml, worded_faults, written_key
from holonom.app.fields.toml_lines import key_lines
from holonom.errors import CellError
from holonom.files import read_text

__all__ = ["load_cell", "place_in"]


def load_cell(path: str | Path, *, allow_outside: bool = False) -> Cell:
    """Read and check a cell file.

    Parameters
    ----------
    path : the TOML file; the files that it names are relative to its folder.
    allow_outside : programs, locations, photograph and layout may lie outside of that folder.

    Returns
    -------
    The cell, in SI units and radians, with files as paths that exist; short forms are written out.

    Raises
    ------
    CellError
        One line for each fault: file, line, key, what came, what is expected.
    """
    path = Path(path)
    text = _read(path)
    written = _written(path, text)
    try:
        return Cell.model_validate(written.data, context={"folder": path.parent, "outside": allow_outside})
    except ValidationError as error:
        faults = error.errors(include_url=False)
        raise CellError(worded_faults(path, text, Cell, faults, place=written.place, also=written.also)) from None


def place_in(path: Path, *keys: str | int) -> str:
    """Return `file:line: key` of a key of `Cell` as the file has it, for messages."""
    text = _read(path)
    at = _written(path, text).place(keys)
    return f"{path}:{line_of(at, key_lines(text))}: {written_key(at)}"


def _written(path: Path, text: str) -> Written:
    data = parse_toml(path, text, CellError)
    try:
        return written_out(data)
    except Misplaced as problem:
        line = line_of((problem.key,), key_lines(text))
        raise CellError(f"{path}:{line}: {problem.key}: {problem}") from None


def _read(path: Path) -> str:
    return read_text(path, "cell", CellError)
