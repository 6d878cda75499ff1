"""Folders of the OptiOdom data set (Sousa, Petry, Costa & Moreira 2020), as they are published.

A folder holds `<stamp>_metadata.csv` and `<stamp>_run-NN.csv` (or .csv.gz), without header: time s, x m, y m, theta rad
by the ground truth, then what each wheel moved in the sample, in encoder ticks (of a tricycle: ticks, steering rad).
Their wheel columns: differential right, left; mecanum front left, front right, rear left, rear right, the right ones
counting backwards; omni3 at -60, 60, 180 degrees, counting clockwise.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from holonom.app.odometry_log.checks import check_time, in_one_clock, part_names
from holonom.app.odometry_log.log import OdometryLog
from holonom.app.odometry_log.table import Table, read_table
from holonom.arrays import Array
from holonom.errors import LogError
from holonom.files import decimal, read_text
from holonom.mobile.calibration import DRIVES, Run, article, drive_parameters
from holonom.mobile.odometry import angle_per_tick

__all__ = ["drive_of", "find_sets", "read_optiodom"]


METADATA = re.compile(r"(.+)_metadata\.csv(\.gz)?")
RUN = re.compile(r"(.+)_run-(\d+)\.csv(\.gz)?")
EVEN = 1.5  # samples are even: a step above that many times the median one has lost one
POSE = ("time", "x", "y", "theta")


@dataclass(frozen=True, slots=True)
class _Type:
    """One `type` of the data set: the drive, its wheel columns with their signs, lengths `Li` to the lever."""

    drive: str
    columns: tuple[str, ...]
    signs: tuple[float, ...]
    lengths: int


TYPES = {
    "diff": _Type("differential", ("right", "left"), (1.0, 1.0), 1),
    "tricyc": _Type("tricycle", ("front", "steering"), (1.0,), 1),
    "omni3": _Type("omni3", ("wheel_1", "wheel_2", "wheel_3"), (-1.0, -1.0, -1.0), 1),
    "omni4": _Type("mecanum", ("front_left", "front_right", "rear_left", "rear_right"), (1.0, -1.0, 1.0, -1.0), 2),
}


def find_sets(folder: Path) -> list[Path]:
    """Metadata files in a folder and those below it, sorted."""
    return sorted(path for path in folder.rglob("*_metadata.csv*") if METADATA.fullmatch(path.name))


def drive_of(metadata: Path) -> str:
    """Drive of a set, by its metadata.

    Raises
    ------
    LogError
    """
    return _Facts(metadata).kind.drive


def read_optiodom(metadata: Path, *, only: Iterable[Path] = (), allow_gaps: bool = False) -> OdometryLog:
    """Read one set of runs.

    Parameters
    ----------
    metadata : the set's `_metadata.csv`.
    only : run files to read instead of all.
    allow_gaps : let gaps in time pass with a note.

    Raises
    ------
    LogError
        File, line and column of any fault.
    """
    facts = _Facts(metadata)
    chosen = list(only)
    files = chosen or _run_files(metadata)
    if not files:
        raise LogError(
            f"{metadata.parent}: no run files {_stem(metadata)}_run-*.csv beside the metadata; copy them there"
        )
    runs: list[Run] = []
    notes = [] if chosen else _missing(facts, files)
    for file in files:
        read, doubts = _read_runs(file, facts, allow_gaps=allow_gaps)
        runs += read
        notes += doubts
    return OdometryLog(metadata.parent, facts.kind.drive, facts.nominal, facts.side, tuple(runs), tuple(notes))


class _Facts:
    """What the metadata say; every fault with its line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.rows: dict[str, list[str]] = {}
        self.lines: dict[str, int] = {}
        for number, line in enumerate(read_text(path, "description", LogError).split("\n"), start=1):
            key, *cells = (cell.strip() for cell in line.split(","))
            if key:
                self.rows[key], self.lines[key] = [cell for cell in cells if cell], number
        name = self._cells("type", "one of " + ", ".join(TYPES))[0]
        if name not in TYPES:
            raise LogError(f"{path}:{self.lines['type']}: type {name!r} came; one of {', '.join(TYPES)} is known")
        self.kind = TYPES[name]
        self.angle = angle_per_tick(self._positive("encRes", 1)[0], self._positive("ngear", 1)[0])
        self.nominal = self._nominal()
        self.side = self._positive("L", 1)[0] if self.rows.get("L") else None
        self.count = int(self._positive("N", 1)[0]) if self.rows.get("N") else None

    def _nominal(self) -> dict[str, float]:
        kind, wheels = self.kind, len(self.kind.signs)
        lever = sum(self._positive("Li", kind.lengths))
        diameters = self._positive("Di", wheels)
        if kind.drive == "tricycle":
            offset = np.radians(self._numbers("Thi", 1)[0]) if self.rows.get("Thi") else 0.0
            values = {"wheelbase": lever, "diameter": diameters[0], "steering_offset": float(offset)}
        else:
            named = {f"diameter_{wheel}": d for wheel, d in zip(kind.columns, diameters, strict=True)}
            values = {DRIVES[kind.drive][0]: lever, **named}
        return {name: values[name] for name in DRIVES[kind.drive]}

    def _cells(self, key: str, meaning: str) -> list[str]:
        if not self.rows.get(key):
            place = f"{self.path}:{self.lines[key]}" if key in self.lines else f"{self.path}"
            raise LogError(f"{place}: {key} is missing or empty; {meaning} is expected")
        return self.rows[key]

    def _numbers(self, key: str, count: int) -> list[float]:
        cells = self._cells(key, f"{count} number(s)")
        place = f"{self.path}:{self.lines[key]}: {key}"
        if len(cells) != count:
            raise LogError(f"{place}: {len(cells)} number(s) came; {article(self.kind.drive)} base has {count}")
        try:
            values = [decimal(cell) for cell in cells]
        except ValueError:
            raise LogError(f"{place}: {', '.join(cells)} came; numbers are expected") from None
        if not np.all(np.isfinite(values)):
            raise LogError(f"{place}: {', '.join(cells)} came; finite numbers are expected")
        return values

    def _positive(self, key: str, count: int) -> list[float]:
        values = self._numbers(key, count)
        if min(values) <= 0.0:
            raise LogError(
                f"{self.path}:{self.lines[key]}: {key}: {min(values):g} came; numbers above zero are expected"
            )
        return values


def _stem(metadata: Path) -> str:
    match = METADATA.fullmatch(metadata.name)
    assert match is not None
    return match[1]


def _run_files(metadata: Path) -> list[Path]:
    stem = _stem(metadata)
    found: dict[int, Path] = {}
    for path in sorted(metadata.parent.iterdir()):
        match = RUN.fullmatch(path.name)
        if match and match[1] == stem:
            number = int(match[2])
            if number in found:
                raise LogError(f"{path}: run {number} is there twice, also as {found[number].name}; remove one of them")
            found[number] = path
    return [found[number] for number in sorted(found)]


def _missing(facts: _Facts, files: list[Path]) -> list[str]:
    if facts.count is None or facts.count == len(files):
        return []
    return [
        f"{facts.path}:{facts.lines['N']}: N names {facts.count} runs, {len(files)} are here: results over all runs "
        "that were published for the set may differ"
    ]


def _read_runs(path: Path, facts: _Facts, *, allow_gaps: bool) -> tuple[list[Run], tuple[str, ...]]:
    """One run of a file, or the parts between its gaps."""
    table = read_table(path, (*POSE, *facts.kind.columns))
    parts, notes = check_time(table, allow_gaps=allow_gaps, running=False, factor=EVEN)
    runs = []
    for name, part in zip(part_names(path, len(parts)), parts, strict=True):
        run, doubts = _read_part(name, part, facts, first=part.lines[0] == table.lines[0])
        runs.append(run)
        notes += doubts
    return runs, notes


def _read_part(name: str, table: Table, facts: _Facts, *, first: bool) -> tuple[Run, tuple[str, ...]]:
    kind = facts.kind
    wheels = kind.columns[: len(kind.signs)]
    turns = np.stack([table.column(name) for name in wheels], axis=1) * np.array(kind.signs) * facts.angle
    turns[0] *= first  # what came before a part is none of its own
    steering = table.column("steering")[:, None] if "steering" in kind.columns else np.empty((len(turns), 0))
    order = [1, 0] if kind.drive == "differential" else list(range(len(wheels)))
    run = Run(name, table.column("time"), np.ascontiguousarray(turns[:, order]), _truth(table), steering)
    parameters = drive_parameters(kind.drive, facts.nominal)
    return in_one_clock(table, run, parameters, [wheels[k] for k in order], as_published=True)


def _truth(table: Table) -> Array:
    return np.stack([table.column(name) for name in POSE[1:]], axis=1)
