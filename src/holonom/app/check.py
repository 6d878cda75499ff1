"""`holonom check`: what is wrong with a program or a cell, found without moving anything."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from holonom.app.answer import Answer
from holonom.app.short_cell import ArmCell, load_cell
from holonom.errors import InputError

__all__ = ["check_file"]


def check_file(path: Path) -> Answer:
    """Check a program (.arps) by compiling it, or a cell by also planning every motion that it asks for.

    Raises
    ------
    InputError
        All that was found, a line each with file and line. A file of another type.
    """
    check = _CHECKS.get(path.suffix.lower())
    if check is None:
        raise InputError(
            f"{path}: {_what_came(path)}; holonom check takes a program (.arps) or a cell file (.toml). "
            "A robot description (.urdf, .xacro) is checked when it is loaded: holonom.load_arm(path)"
        )
    return check(path)


def _what_came(path: Path) -> str:
    if path.is_dir():
        return "a folder"
    return f"a file of type {path.suffix!r}" if path.suffix else "a file without an ending"


def _program(path: Path) -> Answer:
    from holonom.app.arm.check import check_program

    return check_program(path)


def _cell(path: Path) -> Answer:
    cell = load_cell(path)
    if isinstance(cell, ArmCell):
        from holonom.app.arm.check import check_arm

        return check_arm(cell, path)
    from holonom.app.base.check import check_base

    return check_base(cell, path)


_CHECKS: Mapping[str, Callable[[Path], Answer]] = {".arps": _program, ".toml": _cell}
