"""`new_cell`: a folder with a cell and a program that run at once, tried before anything is written."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from holonom.app.cell.check import check_cell
from holonom.app.console.answer import Answer
from holonom.app.console.progress import Progress
from holonom.app.start.arm import PROGRAM, arm_starts, source_of
from holonom.app.start.base import base_starts
from holonom.app.start.text import head
from holonom.errors import InputError, OutputError
from holonom.model import ArmModel, reach

__all__ = ["KINDS", "Files", "new_cell"]

CELL = "cell.toml"
BASE, ARM = "agv", "arm"
CARRIER = "omni"
"""Arrangement of a base that carries an arm."""
SIGNALS = 1, 2

Files = Mapping[str, str]
"""Text of each file of a folder, by its name."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of cell: the model unless one is named, and `files(name of the cell, model, folder)`, the best first."""

    model: str
    files: Callable[[str, str, Path], Iterator[Files]]


def _arm(name: str, given: str, folder: Path) -> Iterator[Files]:
    source, model = source_of(given, folder)
    about = head(name, f"An arm, {model.name}, and its program.")
    for start in arm_starts(source, model):
        yield {CELL: about + start.table(), PROGRAM: start.program()}


def _base(name: str, given: str, folder: Path) -> Iterator[Files]:
    about = head(name, f"A mobile base, {given}, and where it drives.")
    for start in base_starts(given):
        yield {CELL: about + start.table()}


def _agv(name: str, given: str, folder: Path) -> Iterator[Files]:
    source, model = source_of(given, folder)
    about = head(name, f"An arm, {model.name}, on a base: it moves, the base drives, it moves again.")
    for base in base_starts(CARRIER, scale=max(1.0, reach(model)), mass=_carrier_mass(model), signals=SIGNALS):
        for arm in arm_starts(source, model):
            text = f"{about}{base.table(BASE)}\n{arm.table(ARM, on=f'{BASE}.top')}"
            yield {CELL: text, PROGRAM: arm.program(SIGNALS)}


def _carrier_mass(model: ArmModel) -> float:
    """Mass of a base that stands under an arm, kg: four times the arm's, in tens."""
    return max(20.0, 10.0 * math.ceil(0.4 * sum(body.mass for body in model.bodies or ())))


KINDS: Mapping[str, Kind] = {
    "arm": Kind("puma560", _arm),
    "base": Kind("differential", _base),
    "agv": Kind("ur5e", _agv),
}


def new_cell(kind: str, folder: Path, *, model: str | None = None, quiet: bool = True) -> Answer:
    """Write a commented cell and what it needs into a folder; `holonom run` runs it at once.

    Parameters
    ----------
    kind : of `KINDS`.
    folder : made if need be.
    model : of arm and agv a preset or a .urdf or .xacro file, of a base an arrangement of wheels.
    quiet : no progress bar.

    Raises
    ------
    OutputError
        The folder holds something already, or cannot be written; nothing is written then.
    InputError
        A model that there is not, that is faulty, or that cannot run.
    """
    _refuse_used(folder)
    given = KINDS[kind].model if model is None else model
    with Progress(f"trying programs of {given}", None, quiet=quiet):
        files, checked = _first_sound(kind, given, folder)
    _write(folder, files)
    cell = folder / CELL
    lines = [f"{cell}: {_NAMED[kind].format(Path(given).name)}; it takes about {checked['estimated_time_s']:.1f} s"]
    lines += [f"{folder / file}: its program" for file in files if file != CELL]
    told = {"cell": str(cell), "files": [str(folder / file) for file in files], "kind": kind, "model": given}
    return Answer(
        "\n".join([*lines, f"next: holonom run {cell}"]), told | {"estimated_time_s": checked["estimated_time_s"]}
    )


_NAMED = {"arm": "an arm, {}", "base": "a base, {}", "agv": "an arm, {}, on a base"}


def _first_sound(kind: str, given: str, folder: Path) -> tuple[Files, Mapping[str, Any]]:
    """The first files of a kind in which a check finds nothing, and what it says; tried beside the folder's own."""
    make, name, problem = KINDS[kind].files, folder.resolve().name or kind, "there are warnings"
    with TemporaryDirectory(prefix="holonom-") as place:
        trial = Path(place)
        for tried, files in zip(make(name, given, trial), make(name, given, folder), strict=True):
            for file, text in tried.items():
                (trial / file).write_text(text, "utf-8")
            try:
                checked = check_cell(trial / CELL).data
            except InputError as error:
                problem = str(error).replace(f"{trial}{os.sep}", "")
            else:
                if not checked["warnings"]:
                    return files, checked
    raise InputError(f"no program was found that {given!r} can run; of the last one tried: {problem}")


def _refuse_used(folder: Path) -> None:
    """Raise `OutputError` where a folder is none, or holds something."""
    try:
        found = sorted(path.name for path in folder.iterdir())
    except FileNotFoundError:
        return
    except OSError as error:
        raise OutputError(f"{folder}: {error.strerror}; give a folder that is empty, or is not there yet") from None
    if found:
        more = f" and {len(found) - 3} more" if len(found) > 3 else ""
        raise OutputError(
            f"{folder} holds {', '.join(found[:3])}{more}; nothing is overwritten: give a folder that is empty, or is "
            "not there yet"
        )


def _write(folder: Path, files: Files) -> None:
    """Write files that are not there yet, all or none."""
    done: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            with (folder / name).open("x", encoding="utf-8") as file:
                done.append(folder / name)
                file.write(text)
    except OSError as error:
        for path in done:
            path.unlink(missing_ok=True)
        raise OutputError(f"cannot write to {folder}: {error.strerror}; give another folder") from None
