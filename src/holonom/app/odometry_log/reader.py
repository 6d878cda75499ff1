"""Whatever a path leads to: one log."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from holonom.app.odometry_log.log import OdometryLog
from holonom.app.odometry_log.optiodom import METADATA, RUN, drive_of, find_sets, read_optiodom
from holonom.app.odometry_log.own import read_own
from holonom.app.odometry_log.plain import read_plain
from holonom.errors import LogError
from holonom.mobile.calibration import article

__all__ = ["read_log"]

RUNS = (".csv", ".gz", ".mcap", ".db3")  # endings of run files of the plain format


def read_log(paths: Sequence[Path], *, drive: str | None = None, allow_gaps: bool = False) -> OdometryLog:
    """Read logs as one.

    Parameters
    ----------
    paths : folders of the OptiOdom data set or above several of them, run files of it; TOML files of the plain
        format, or run files beside the one that describes them; recordings of our own runs.
    drive : what was driven; sets of other drives below a folder are passed over. Taken from the logs unless given.
    allow_gaps : let gaps in time pass with a note.

    Returns
    -------
    All runs together; where logs state different geometry, the first one's, with a note.

    Raises
    ------
    LogError
        No log there, logs of several drives, or any fault in one: file, line, column.
    """
    if not paths:
        raise LogError("no log came; give a folder or file")
    logs = [log for path in paths for log in _logs(Path(path), drive, allow_gaps=allow_gaps)]
    _check_twice(logs)
    drives = dict.fromkeys(log.drive for log in logs)
    if drive is not None and list(drives) != [drive]:
        raise LogError(
            f"{logs[0].source} is of {article(next(iter(drives)))} base; {article(drive)} was asked for: see --drive"
        )
    if len(drives) > 1:
        raise LogError(f"the logs are of {', '.join(drives)} bases; name one of them with --drive")
    return logs[0] if len(logs) == 1 else _joined(logs)


def _logs(path: Path, drive: str | None, *, allow_gaps: bool) -> list[OdometryLog]:
    if path.is_dir():
        return _folder(path, drive, allow_gaps=allow_gaps)
    if path.suffix == ".toml":
        return [read_plain(path, allow_gaps=allow_gaps)]
    if METADATA.fullmatch(path.name):
        return [read_optiodom(path, allow_gaps=allow_gaps)]
    run = RUN.fullmatch(path.name)
    if run:
        metadata = path.parent / f"{run[1]}_metadata.csv"
        return [read_optiodom(metadata, only=[path], allow_gaps=allow_gaps)]
    described = sorted(path.parent.glob("*.toml"))
    if path.is_file() and path.suffix == ".mcap" and (own := _own(path, described=bool(described))) is not None:
        return [own]
    if path.is_file() and path.suffix in RUNS and len(described) == 1:
        return [read_plain(described[0], only=path.name, allow_gaps=allow_gaps)]
    reason = "is no log" if path.exists() else "is not there"
    raise LogError(
        f"{path} {reason}; give a folder of the OptiOdom data set, the TOML file that describes a log, or the "
        "recording of a base's run"
    )


def _own(path: Path, *, described: bool) -> OdometryLog | None:
    """A recording of our own; what cannot be read as one is another's where a TOML file describes it."""
    try:
        return read_own(path)
    except LogError:
        if described:
            return None
        raise


def _folder(folder: Path, drive: str | None, *, allow_gaps: bool) -> list[OdometryLog]:
    described = sorted(folder.glob("*.toml"))
    sets = find_sets(folder)
    if len(described) == 1 and not sets:
        return [read_plain(described[0], allow_gaps=allow_gaps)]
    if not sets:
        raise LogError(
            f"{folder}: neither a file *_metadata.csv, here or below, nor one TOML file; give a folder with a log"
        )
    drives = {path: drive_of(path) for path in sets}
    wanted = [path for path in sets if drive in (None, drives[path])]
    if not wanted:
        raise LogError(
            f"{folder}: sets of {', '.join(dict.fromkeys(drives.values()))}, none of {article(str(drive))} base"
        )
    return [read_optiodom(path, allow_gaps=allow_gaps) for path in wanted]


def _check_twice(logs: Sequence[OdometryLog]) -> None:
    """Refuse a run that came twice, by whatever paths: it would count as two."""
    seen: dict[bytes, str] = {}
    for log in logs:
        for run in log.runs:
            numbers = b"".join(np.ascontiguousarray(a).tobytes() for a in (run.time, run.turns, run.truth))
            known, place = seen.get(numbers), f"{run.name} of {log.source}"
            if known is not None:
                raise LogError(f"run {place} came before, as {known}, and would count twice; give each run once")
            seen[numbers] = place


def _joined(logs: Sequence[OdometryLog]) -> OdometryLog:
    first = logs[0]
    notes = [note for log in logs for note in log.notes]
    notes += [
        f"{log.source} states {_geometry(log)}; that of {first.source} is taken for all: {_geometry(first)}"
        for log in logs
        if dict(log.nominal) != dict(first.nominal)
    ]
    sides = list(dict.fromkeys(log.side for log in logs))
    return dataclasses.replace(
        first,
        side=first.side if len(sides) == 1 else None,
        runs=tuple(run for log in logs for run in log.runs),
        notes=tuple(notes),
        sides=tuple(side for side in sides if side is not None),
        bumped=tuple(name for log in logs for name in log.bumped),
    )


def _geometry(log: OdometryLog) -> str:
    shown = {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in log.nominal.items()}
    return ", ".join(f"{name} {value}" for name, value in shown.items())
