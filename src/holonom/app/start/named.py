"""Which cell a program belongs to, for those who name the program where a cell is wanted."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from holonom.errors import CellError
from holonom.files import LIMITS, is_file

__all__ = ["cells_that_name", "refuse_other"]

MOST = 50
"""Cell files of a folder that are looked at."""
OTHERS: Mapping[str, str] = {
    ".urdf": "a robot: a cell names it as model; holonom new arm FOLDER --model {path} writes one",
    ".xacro": "a robot: a cell names it as model; holonom new arm FOLDER --model {path} writes one",
    ".mcap": "a recording: holonom report {path} tells of it",
    ".loc": "a location file: a cell names the program beside it",
}
"""What files are that no run begins with, by their endings."""


def cells_that_name(program: Path) -> list[Path]:
    """Cell files in the folder of a program, and above, that name it."""
    name, folder = program.name, program.parent
    found = []
    for cell in [*sorted(folder.glob("*.toml"))[:MOST], *sorted(folder.glob("../*.toml"))[:MOST]]:
        try:
            if is_file(cell) and cell.stat().st_size <= LIMITS["cell"].most and name in cell.read_text("utf-8"):
                found.append(cell)
        except (OSError, UnicodeError):
            continue
    return found


def refuse_other(path: Path) -> None:
    """Raise `CellError`, which says what to do, where a file is by its ending no cell."""
    ending = path.suffix.lower()
    if ending in OTHERS:
        raise CellError(f"{path} is {OTHERS[ending].format(path=path)}")
    if ending == ".arps":
        cells = cells_that_name(path) if path.is_file() else []
        todo = f"run the cell that names it: holonom run {cells[0]}" if cells else (
            "a cell says which robot runs it; holonom new arm FOLDER writes one"
        )  # fmt: skip
        raise CellError(f"{path} is a program; {todo}")
