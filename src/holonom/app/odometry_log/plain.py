"""The plain format: a TOML file that says what was driven, and a CSV or MCAP file for each run.

```toml
drive = "differential"            # differential, tricycle, omni3 or mecanum
runs = ["run-1.csv", "run-2.csv"] # beside this file; .csv, .csv.gz or .mcap
side = 1.7                        # of the square, m; for UMBmark, else leave it out

[geometry]                        # m and rad, the names that the drive has
wheelbase = 0.2
diameter_left = 0.084
diameter_right = 0.084

[encoder]                         # for wheels in ticks
ticks = 64                        # per turn of the encoder's shaft
gear = 43.7                       # turns of that shaft per turn of the wheel
bits = 16                         # of running counters that run over, else leave it out

[units]                           # of the columns
wheels = "ticks"                  # "ticks" or "rad" of each sample, "counts" or "angle" that run on
steering = "rad"                  # or "deg"
position = "m"                    # or "mm"
heading = "rad"                   # or "deg"

[mcap]                            # for MCAP runs, where names differ
joints = "/joint_states"          # topic of the wheels' angles; the first of its type unless given
truth = "/ground_truth"           # topic of the truth, likewise
names = { left = "wheel_left_joint" }
```

The first line of a CSV file names its columns, in any order: `time` (s), one per wheel of the drive (`left`, `right`),
`steering` for a tricycle, and `x`, `y`, `theta` of the truth where there is one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from holonom.app.odometry_log.checks import check_motion, check_time
from holonom.app.odometry_log.log import OdometryLog
from holonom.app.odometry_log.mcap_file import JOINTS, ODOMETRY, read_mcap_table
from holonom.app.odometry_log.table import Table, read_table, read_text
from holonom.app.toml_lines import key_lines
from holonom.errors import CalibrationError, LogError, OutOfLimits
from holonom.mobile.calibration import Run, drive_parameters, wheels_of
from holonom.mobile.odometry import angle_per_tick, count_differences

__all__ = ["Description", "read_description", "read_plain"]

Array = NDArray[np.float64]

TRUTH = ("x", "y", "theta")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)


class Encoder(_Table):
    """Encoder of every wheel."""

    ticks: float = Field(gt=0.0, allow_inf_nan=False)
    gear: float = Field(default=1.0, gt=0.0, allow_inf_nan=False)
    bits: int | None = Field(default=None, ge=1, le=52)


class Units(_Table):
    """What the columns hold."""

    wheels: Literal["ticks", "counts", "rad", "angle"] = "rad"
    steering: Literal["rad", "deg"] = "rad"
    position: Literal["m", "mm"] = "m"
    heading: Literal["rad", "deg"] = "rad"


class McapNames(_Table):
    """What MCAP runs call topics and joints."""

    joints: str | None = None
    truth: str | None = None
    names: Mapping[str, str] = {}


class Description(_Table):
    """The TOML file of a log."""

    drive: Literal["differential", "tricycle", "omni3", "mecanum"]
    runs: list[str] = Field(min_length=1)
    side: float | None = Field(default=None, gt=0.0, allow_inf_nan=False)
    geometry: Mapping[str, float]
    encoder: Encoder | None = None
    units: Units = Units()
    mcap: McapNames = McapNames()


def read_description(path: Path) -> Description:
    """Read the TOML file of a log.

    Raises
    ------
    LogError
        File, line and key of every fault.
    """
    text = read_text(path)
    try:
        description = Description.model_validate(tomllib.loads(text))
        drive_parameters(description.drive, description.geometry)
    except tomllib.TOMLDecodeError as error:
        raise LogError(f'{path}: not TOML: {error}; expected lines such as drive = "differential"') from None
    except ValidationError as error:
        lines = key_lines(text)
        faults = [
            f"{path}:{_line(lines, fault['loc'])}: {'.'.join(map(str, fault['loc']))}: {fault['msg']}"
            for fault in error.errors(include_url=False)
        ]
        raise LogError("\n".join(faults)) from None
    except (CalibrationError, OutOfLimits) as error:
        raise LogError(f"{path}:{key_lines(text).get(('geometry',), 1)}: geometry: {error}") from None
    if description.units.wheels in ("ticks", "counts") and description.encoder is None:
        raise LogError(f"{path}: wheels are in {description.units.wheels} and there is no [encoder]; state its ticks")
    return description


def read_plain(path: Path, *, only: str | None = None, allow_gaps: bool = False) -> OdometryLog:
    """Read a log of the plain format by its TOML file: all its runs, or the only one that is named.

    Raises
    ------
    LogError
    """
    description = read_description(path)
    runs: list[Run] = []
    notes: list[str] = []
    if only is not None and only not in description.runs:
        raise LogError(f"{path} does not name {only} among its runs ({', '.join(description.runs)}); add it")
    for name in description.runs if only is None else [only]:
        run, gaps = read_run(path.parent / name, description, allow_gaps=allow_gaps)
        runs.append(run)
        notes += gaps
    return OdometryLog(path, description.drive, description.geometry, description.side, tuple(runs), tuple(notes))


def read_run(path: Path, description: Description, *, allow_gaps: bool = False) -> tuple[Run, tuple[str, ...]]:
    """Read one CSV or MCAP file as a description says; the run, and notes on gaps.

    Raises
    ------
    LogError
    """
    wheels, steered = wheels_of(description.drive)
    columns = ("time", *wheels, *(("steering",) if steered else ()))
    if path.suffix == ".mcap":
        called = description.mcap
        topics = {JOINTS: called.joints, ODOMETRY: called.truth}
        table = read_mcap_table(path, wheels, steered, topics=topics, names=called.names)
        units = Units(wheels="angle")
    else:
        table, units = read_table(path), description.units
    _check_columns(table, columns)
    running = units.wheels in ("counts", "angle")
    notes = check_time(table, allow_gaps=allow_gaps or running)
    steering = (
        table.column("steering")[:, None] * _factor(units.steering) if steered else np.empty((len(table.values), 0))
    )
    run = Run(
        path.name.split(".")[0], table.column("time"), _turns(table, wheels, description, units), _truth(table, units),
        steering,
    )  # fmt: skip
    check_motion(table, run, drive_parameters(description.drive, description.geometry), wheels)
    return run, notes


def _check_columns(table: Table, columns: tuple[str, ...]) -> None:
    truth = [name for name in TRUTH if name in table.names]
    wanted = columns if not truth else (*columns, *TRUTH)
    missing = [name for name in wanted if name not in table.names]
    if missing:
        raise LogError(
            f"{table.path}:1: no column {', '.join(missing)}; there is {', '.join(table.names)}: the drive needs "
            f"{', '.join(columns)}, and x, y, theta all or none"
        )
    surplus = [name for name in table.names if name not in (*columns, *TRUTH)]
    if surplus:
        raise LogError(f"{table.path}:1: column {surplus[0]} is unknown; {', '.join((*columns, *TRUTH))} are read")


def _turns(table: Table, wheels: tuple[str, ...], description: Description, units: Units) -> Array:
    values = np.stack([table.column(name) for name in wheels], axis=1)
    encoder = description.encoder
    if units.wheels == "counts":
        assert encoder is not None
        values = count_differences(values, encoder.bits)
    elif units.wheels == "angle":
        values = count_differences(values)
    if units.wheels in ("ticks", "counts"):
        assert encoder is not None
        values = values * angle_per_tick(encoder.ticks, encoder.gear)
    return np.ascontiguousarray(values)


def _truth(table: Table, units: Units) -> Array:
    if "x" not in table.names:
        return np.empty((0, 3))
    scale = np.array([_factor(units.position), _factor(units.position), _factor(units.heading)])
    return np.stack([table.column(name) for name in TRUTH], axis=1) * scale


def _factor(unit: str) -> float:
    return {"m": 1.0, "rad": 1.0, "mm": 1e-3, "deg": np.pi / 180.0}[unit]


def _line(lines: Mapping[tuple[str | int, ...], int], loc: tuple[str | int, ...]) -> int:
    return next((lines[loc[:k]] for k in range(len(loc), 0, -1) if loc[:k] in lines), 1)
