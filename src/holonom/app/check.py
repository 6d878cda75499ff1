"""`holonom check`: what is wrong with a program or a cell, found without moving anything."""

from __future__ import annotations

from pathlib import Path

from holonom.app.answer import Answer
from holonom.app.cell import ArmCell, load_cell

__all__ = ["check_file"]


def check_file(path: Path) -> Answer:
    """Check a program (.arps) by compiling it, or a cell by also planning every motion that it asks for.

    Raises
    ------
    InputError
        All that was found, a line each with file and line.
    """
    from holonom.app.arm.check import check_arm, check_program

    if path.suffix.lower() == ".arps":
        return check_program(path)
    cell = load_cell(path)
    if isinstance(cell, ArmCell):
        return check_arm(cell, path)
    from holonom.app.base.check import check_base

    return check_base(cell, path)
