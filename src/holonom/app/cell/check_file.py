"""`holonom check`: what is wrong with a program, a cell, a motor or an axis, found without moving anything."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.errors import InputError

__all__ = ["check_file", "check_program"]


def check_file(path: Path, *, quiet: bool = True, allow_outside: bool = False) -> Answer:
    """Check a program (.arps) by compiling it, or a cell by also planning every motion that it asks for.

    A file with a table `[motor]` is that of a motor or an axis: its data sheet is checked against itself.

    A check that takes longer than a moment shows how far it is, unless it is to be `quiet`. `allow_outside`: what a
    cell names may lie outside of its folder; so may the location file beside a program.

    Raises
    ------
    InputError
        All that was found, a line each with file and line. A file of another type.
    """
    kind = path.suffix.lower()
    if kind not in _CHECKS:
        raise InputError(
            f"{path}: {_what_came(path)}; holonom check takes a program (.arps), or the file of a cell, motor or axis "
            "(.toml). A robot description (.urdf, .xacro) is checked when it is loaded: holonom.load_arm(path)"
        )
    return _CHECKS[kind](path, quiet, allow_outside)


def check_program(path: Path, allow_outside: bool = False) -> Answer:
    """Check a program (.arps) by compiling it.

    Raises
    ------
    ProgramError
        All that was found, a line each.
    """
    from holonom.app.start.named import cells_that_name
    from holonom.lang import load_program

    program = load_program(path, allow_outside=allow_outside)
    names = ", ".join(routine.name for routine in program.routines)
    warnings = [warning.render() for warning in program.warnings]
    cells = [str(cell) for cell in cells_that_name(path)]
    lines = [f"{path}: no errors; programs: {names}", *(f"warning: {warning}" for warning in warnings)]
    lines += [f"note: its motions are checked with the cell that names it: holonom check {cell}" for cell in cells[:1]]
    return Answer("\n".join(lines), {"file": program.file, "kind": "program", "warnings": warnings, "cells": cells})


def _what_came(path: Path) -> str:
    if path.is_dir():
        return "a folder"
    return f"a file of type {path.suffix!r}" if path.suffix else "a file without an ending"


def _program(path: Path, quiet: bool, allow_outside: bool) -> Answer:
    del quiet  # it takes no time
    return check_program(path, allow_outside)


def _cell(path: Path, quiet: bool, allow_outside: bool) -> Answer:
    from holonom.app.cell.check import check_cell
    from holonom.app.drives.check import check_drive
    from holonom.app.drives.files import is_drive, is_process

    if is_drive(path):
        return check_drive(path)
    if is_process(path):
        raise InputError(f"{path}: a process is not checked but tuned, which says what is wrong: holonom tune {path}")
    return check_cell(path, quiet=quiet, allow_outside=allow_outside)


_CHECKS: Mapping[str, Callable[[Path, bool, bool], Answer]] = {".arps": _program, ".toml": _cell}
