"""Writing a log in the plain format."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from holonom.app.console.output import prepare_output
from holonom.app.odometry_log.log import Columns, OdometryLog
from holonom.app.odometry_log.mcap_file import write_mcap
from holonom.arrays import Array
from holonom.errors import OutputError
from holonom.mobile.calibration import Run

__all__ = ["write_log"]


def write_log(
    log: OdometryLog,
    folder: str | Path,
    *,
    runs: Literal["csv", "mcap"] = "csv",
    others: Mapping[str, Sequence[Array]] | None = None,
) -> Path:
    """Write a log into a folder: `log.toml`, and a CSV or MCAP file for each run.

    Parameters
    ----------
    runs : form of the runs.
    others : in MCAP files, topic -> poses (N, 3) of each run by other odometry, to look at beside the truth.

    Returns
    -------
    The TOML file.

    Raises
    ------
    OutputError
    """
    if log.base is not None:
        raise OutputError(
            f"{log.source} is a recording whose wheels no log of the plain format names; leave --mcap out"
        )
    path, called = prepare_output(folder), log.subject.columns
    names = [f"{number:03d}-{run.name}.{runs}" for number, run in enumerate(log.runs, start=1)]
    units = "angle" if runs == "mcap" else "rad"
    lines = [f'drive = "{log.drive}"', f"runs = {json.dumps(names)}"]
    lines += [] if log.side is None else [f"side = {log.side!r}"]
    bumped = [name for name, run in zip(names, log.runs, strict=True) if run.name in log.bumped]
    lines += [f"bumped = {json.dumps(bumped)}"] if bumped else []
    lines += ["", "[geometry]", *(f"{name} = {_value(value)}" for name, value in log.nominal.items())]
    lines += ["", "[units]", f'wheels = "{units}"', ""]
    try:
        for k, (name, run) in enumerate(zip(names, log.runs, strict=True)):
            if runs == "mcap":
                write_mcap(path / name, run, called, others={t: rows[k] for t, rows in (others or {}).items()})
            else:
                _write_csv(path / name, run, called)
        (path / "log.toml").write_text("\n".join(lines), encoding="utf-8")
    except OSError as error:
        raise OutputError(f"cannot write to {path}: {error.strerror}; give a folder that can be written") from None
    return path / "log.toml"


def _value(value: object) -> str:
    return json.dumps(value) if isinstance(value, (list, tuple)) else repr(value)


def _write_csv(path: Path, run: Run, called: Columns) -> None:
    header = ["time", *called.wheels, *called.steering, *(("x", "y", "theta") if len(run.truth) else ())]
    parts = [run.time, run.turns, run.steering, *([run.truth] if len(run.truth) else [])]
    np.savetxt(path, np.column_stack(parts), fmt="%.17g", delimiter=",", header=",".join(header), comments="")
