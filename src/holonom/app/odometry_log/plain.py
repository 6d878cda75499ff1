"""The plain format: a TOML file that says what was driven, and a CSV or MCAP file for each run.

```toml
drive = "differential"            # differential, tricycle, omni3, mecanum, omni3_any to omni6_any, or an arrangement
runs = ["run-1.csv", "run-2.csv"] # beside this file; .csv, .csv.gz, .mcap, .db3 or the folder of a rosbag2
side = 1.7                        # of the square, m; for UMBmark, else leave it out

bumped = ["run-2.csv"]            # runs over bumps, else leave it out

[geometry]                        # m and rad, the names that the drive has, or arguments of the arrangement
wheelbase = 0.2
diameter_left = 0.084
diameter_right = 0.084

[encoder]                         # for wheels in ticks
ticks = 64                        # per turn of the encoder's shaft
gear = 43.7                       # turns of that shaft per turn of the wheel
bits = 16                         # of running counters that run over, else leave it out

[units]                           # of the columns
time = "s"                        # or "ms", "us", "ns"; unless given told by their size, as stamps since 1970 have it
wheels = "ticks"                  # "ticks" or "rad" of each sample, "counts" or "angle" that run on
steering = "rad"                  # or "deg"
position = "m"                    # or "mm"
heading = "rad"                   # or "deg"

[mcap]                            # for recordings, where names differ
joints = "/joint_states"          # topic of the wheels' angles; the first of its type unless given
truth = "/ground_truth"           # topic of the truth, likewise: odometry, poses or transforms
frame = "robot"                   # of the base in transforms; base_link or the only one unless given
names = { left = "wheel_left_joint" }
```

The first line of a CSV file names its columns, in any order: `time`, one per wheel of the drive (`left`, `right`),
`steering` for one steered wheel (of several `front_left_steering` and so on), and `x`, `y`, `theta` of the truth where
there is one. Commas, semicolons (numbers may then have decimal commas) or tabs separate them; other columns are noted
and not read, but for `gyro` (rad/s) and `flow_x`, `flow_y` (counts of an optical sensor in each sample), which are
calibrated beside the wheels. Where wheels and truth come at two rates the cells of what was not sampled are empty, and
the truth is interpolated to the times of the wheels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from holonom.app.fields.quantities import OneOf
from holonom.app.fields.toml_faults import line_of, parse_toml, worded_faults
from holonom.app.fields.toml_lines import key_lines
from holonom.app.odometry_log.checks import check_time, in_one_clock, part_names
from holonom.app.odometry_log.log import Columns, OdometryLog, Subject, subject_of
from holonom.app.odometry_log.mcap_file import read_mcap_table
from holonom.app.odometry_log.rates import in_seconds, on_one_rate
from holonom.app.odometry_log.recorded.bag import is_bag, lost_of
from holonom.app.odometry_log.table import Table, read_table
from holonom.arrays import Array
from holonom.errors import CalibrationError, LogError, OutOfLimits
from holonom.files import read_text
from holonom.mobile.calibration import DRIVES, Run
from holonom.mobile.methods import ARRANGEMENTS
from holonom.mobile.odometry import angle_per_tick, count_differences

__all__ = ["Description", "read_description", "read_plain"]


TRUTH = ("x", "y", "theta")
GYRO, FLOW = "gyro", ("flow_x", "flow_y")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)


class Encoder(_Table):
    """Encoder of every wheel."""

    ticks: float = Field(gt=0.0, allow_inf_nan=False)
    """ticks per turn of the encoder's shaft"""
    gear: float = Field(default=1.0, gt=0.0, allow_inf_nan=False)
    """turns of that shaft per turn of the wheel"""
    bits: int | None = Field(default=None, ge=1, le=52)
    """width of running counters that run over, in bits"""


class Units(_Table):
    """What the columns hold."""

    time: Literal["s", "ms", "us", "ns"] | None = None
    """unit of time; told by the size of stamps since 1970 unless given"""
    wheels: Literal["ticks", "counts", "rad", "angle"] = "rad"
    """ticks or rad of each sample, counts or angle that run on"""
    steering: Literal["rad", "deg"] = "rad"
    """unit of steering angles"""
    position: Literal["m", "mm"] = "m"
    """unit of the truth's place"""
    heading: Literal["rad", "deg"] = "rad"
    """unit of the truth's heading"""


class McapNames(_Table):
    """What MCAP runs call topics and joints."""

    joints: str | None = None
    """topic of the wheels' angles"""
    truth: str | None = None
    """topic of the truth"""
    frame: str | None = None
    """of the base, where the truth is transforms"""
    names: Mapping[str, str] = {}
    """of joints by those of wheels"""


class _Driven:
    """Names of what may be driven."""

    def __iter__(self) -> Iterator[str]:
        yield from DRIVES
        yield from (name for name in ARRANGEMENTS if name not in DRIVES)


class Description(_Table):
    """The TOML file of a log."""

    drive: Annotated[str, OneOf(_Driven())]
    """what was driven: differential, tricycle, omni3 or mecanum, or any arrangement of wheels"""
    runs: list[str] = Field(min_length=1)
    """files of the runs beside this one, in quotes and brackets"""
    side: float | None = Field(default=None, gt=0.0, allow_inf_nan=False)
    """side of the square, m"""
    bumped: list[str] = []
    """files of the runs that went over bumps"""
    geometry: Mapping[str, Any]
    """table of the base's numbers, m and rad, or of the arguments of its arrangement"""
    encoder: Encoder | None = None
    """table with the encoder of every wheel"""
    units: Units = Units()
    """table with the units of the columns"""
    mcap: McapNames = McapNames()
    """table with the names in MCAP files"""

    @property
    def subject(self) -> Subject:
        """What was driven."""
        return subject_of(self.drive, self.geometry)


def read_description(path: Path) -> Description:
    """Read the TOML file of a log.

    Raises
    ------
    LogError
        File, line and key of every fault.
    """
    text = read_text(path, "description", LogError)
    data = parse_toml(path, text, LogError, example='drive = "differential"')
    try:
        description = Description.model_validate(data)
        nothing = [name for name in description.bumped if name not in description.runs]
        _ = description.subject
    except ValidationError as error:
        raise LogError(worded_faults(path, text, Description, error.errors(include_url=False))) from None
    except (CalibrationError, OutOfLimits) as error:
        raise LogError(f"{path}:{line_of(('geometry',), key_lines(text))}: geometry: {error}") from None
    if nothing:
        line = line_of(("bumped",), key_lines(text))
        raise LogError(f"{path}:{line}: bumped: {', '.join(nothing)} came, which is not among the runs; add it there")
    if description.units.wheels in ("ticks", "counts") and description.encoder is None:
        line = line_of(("units", "wheels"), key_lines(text))
        raise LogError(
            f"{path}:{line}: units.wheels: {description.units.wheels} came and there is no table [encoder]; state "
            "the ticks of its turn there: [encoder] with ticks = 64, and gear = 43.7 where there is one"
        )
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
    bumped: list[str] = []
    if only is not None and only not in description.runs:
        raise LogError(f"{path} does not name {only} among its runs ({', '.join(description.runs)}); add it")
    for name in description.runs if only is None else [only]:
        read, doubts = read_runs(path.parent / name, description, allow_gaps=allow_gaps)
        runs += read
        notes += doubts
        bumped += [run.name for run in read if name in description.bumped]
    return OdometryLog(
        path, description.drive, description.subject.geometry, description.side, tuple(runs), tuple(notes),
        bumped=tuple(bumped),
    )  # fmt: skip


def read_runs(path: Path, description: Description, *, allow_gaps: bool = False) -> tuple[list[Run], tuple[str, ...]]:
    """Read one CSV or MCAP file as a description says; the run, or its parts between gaps, and notes.

    Raises
    ------
    LogError
    """
    names = description.subject.columns
    columns = ("time", *names.wheels, *names.steering)
    if is_bag(path):
        called = description.mcap
        table = read_mcap_table(
            path, names, joints_topic=called.joints, truth_topic=called.truth, names=called.names,
            frame=called.frame,
        )  # fmt: skip
        units = Units(wheels="angle")
    else:
        wanted = {*columns, *TRUTH, GYRO, *FLOW}
        table, units = read_table(path, needed=wanted, sparse=wanted - {"time"}), description.units
    _check_columns(table, columns)
    surplus = f"{path}:1: not read: column {', '.join(table.ignored)}"
    said = [surplus] if table.ignored else []
    table = on_one_rate(in_seconds(table, units.time), columns[1:], TRUTH)
    running = units.wheels in ("counts", "angle")
    parts, notes = check_time(table, allow_gaps=allow_gaps, running=running)
    notes = (*said, *(lost_of(path) if is_bag(path) else ()), *notes)
    runs = []
    for name, part in zip(part_names(path, len(parts)), parts, strict=True):
        run, doubts = _read_part(name, part, description, units, first=part.lines[0] == table.lines[0])
        runs.append(run)
        notes += doubts
    return runs, notes


def _read_part(
    name: str, table: Table, description: Description, units: Units, *, first: bool
) -> tuple[Run, tuple[str, ...]]:
    subject = description.subject
    names: Columns = subject.columns
    angles = [table.column(name) * _factor(units.steering) for name in names.steering]
    steering = np.stack(angles, axis=1) if angles else np.empty((len(table.values), 0))
    turns = _turns(table, names.wheels, description, units)
    turns[0] *= first  # what came before a part is none of its own
    run = Run(name, table.column("time"), turns, _truth(table, units), steering, *_others(table))
    return in_one_clock(table, run, subject.parameters(), names.wheels)


def _check_columns(table: Table, columns: tuple[str, ...]) -> None:
    truth = [name for name in TRUTH if name in table.names]
    wanted = columns if not truth else (*columns, *TRUTH)
    missing = [name for name in wanted if name not in table.names]
    if missing:
        raise LogError(
            f"{table.path}:1: no column {', '.join(missing)}; there is {', '.join((*table.names, *table.ignored))}: "
            f"the drive needs {', '.join(columns)}, and x, y, theta all or none"
        )


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


def _others(table: Table) -> tuple[Array, Array]:
    """Rates of a gyro (N,) and counts of an optical sensor (N, 2), where there are columns of them."""
    for name in (GYRO, *FLOW):
        if name in table.names and np.isnan(table.column(name)).any():
            row = int(np.argmax(np.isnan(table.column(name))))
            table.fault(row, name, "an empty cell where the wheels were sampled; give a number in each such row")
    rate = table.column(GYRO) if GYRO in table.names else np.empty(0)
    if sum(name in table.names for name in FLOW) == 1:
        raise LogError(f"{table.path}:1: one of flow_x and flow_y came; give both or none")
    flow = np.stack([table.column(name) for name in FLOW], axis=1) if FLOW[0] in table.names else np.empty((0, 2))
    return rate, flow


def _factor(unit: str) -> float:
    return {"m": 1.0, "rad": 1.0, "mm": 1e-3, "deg": np.pi / 180.0}[unit]
