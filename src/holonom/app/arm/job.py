"""What a run needs and a check looks at: a cell with its program, the parts in its photograph and its arm."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.arm.assembly import build_arm
from holonom.app.arm.camera import Seen, look
from holonom.app.arm.cell_model import ArmCell
from holonom.app.cell.taught import taught_problems
from holonom.app.toml_lines import place_of
from holonom.errors import CellError, ModelError, ProgramFault
from holonom.lang import Program, load_program, start
from holonom.machine.arm.servos import check_drives
from holonom.mechanics import Arm

__all__ = ["Job", "load_job"]


@dataclass(frozen=True, slots=True)
class Job:
    """A cell, read and looked at. `unreachable`: taught locations that the arm cannot go to, a line of text each."""

    cell: ArmCell
    program: Program
    seen: Seen | None
    arm: Arm
    unreachable: tuple[str, ...]


def load_job(cell: ArmCell, path: Path) -> Job:
    """Read all that a cell, the file `path`, names. Nothing is written.

    Raises
    ------
    CellError
        The cell's calibration points, its entry or its drives.
    ImageError
        The photograph is missing or not an image.
    ProgramError
        The program or its location file.
    """
    seen = look(cell, path) if cell.camera is not None else None
    file = cell.program.file
    places = cell.program.locations or file.with_suffix(".loc")
    program = load_program(file, cell.program.locations)
    try:
        start(program, entry=cell.program.entry)
    except ProgramFault as fault:
        raise CellError(f"{place_of(path, 'program', 'entry')}: {fault}") from None
    arm = build_arm(cell)
    try:
        check_drives(arm.model)
    except ModelError as problem:
        raise CellError(f"{place_of(path, 'arm', 'preset')}: {problem}; puma560 has them") from None
    return Job(cell, program, seen, arm, tuple(taught_problems(arm, cell.arm.home, program, places)))
