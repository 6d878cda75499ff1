"""`holonom run`: a cell file becomes a recording, a summary and a report."""

from __future__ import annotations

from pathlib import Path

from holonom.app.answer import Answer
from holonom.app.short_cell import ArmCell, load_cell

__all__ = ["run_cell"]


def run_cell(path: Path, output: Path, *, seed: int | None = None, quiet: bool = True) -> Answer:
    """Run a cell and write `recording.mcap`, `summary.json` and `report.html` into a folder.

    Parameters
    ----------
    path : cell file.
    output : folder to write to, made if need be.
    seed : instead of the cell's own.
    quiet : no progress bar.

    Raises
    ------
    InputError
        Before anything is written.
    RunError
        After the start; recording, summary and report up to that moment are kept.
    """
    cell = load_cell(path)
    if seed is not None:
        cell = cell.model_copy(update={"cell": cell.cell.model_copy(update={"seed": seed})})
    if isinstance(cell, ArmCell):
        from holonom.app.arm.run import run_arm

        return run_arm(cell, path, output, quiet=quiet)
    from holonom.app.base.run import run_base

    return run_base(cell, path, output)
