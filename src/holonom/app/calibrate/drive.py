"""`holonom calibrate drive`: static friction, back EMF and inertia of each wheel's drive from a recorded motion."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.odometry_log.table import Table, read_table
from holonom.app.recording import read_recording
from holonom.app.recording.format.pieces import read_pieces
from holonom.app.recording.robot import base_of
from holonom.arrays import Array
from holonom.errors import CalibrationError, InputError, LogError
from holonom.mobile.drive.identification import (
    DriveConstants,
    Estimate,
    MotorConstants,
    identify_drive,
    mechanics_of,
)

__all__ = ["FILE", "calibrate_drive"]


FILE = "drive.json"
UNITS = {"kS": "V", "kV": "V s/rad", "kA": "V s^2/rad"}
MECHANICAL = {"static_friction": "N m", "viscous_friction": "N m s/rad", "inertia": "kg m^2"}


@dataclass(frozen=True, slots=True)
class _Wheel:
    """What a log says of one wheel: time (N,), voltage (N,), and its angle or speed (N,)."""

    time: Array
    voltage: Array
    angle: Array | None
    speed: Array | None


def calibrate_drive(log: Path, *, motor: MotorConstants | None = None, output: Path | None = None) -> Answer:
    """Identify the drives of a base's wheels, or of any motor, from a log with a ramp and a step of the voltages.

    Parameters
    ----------
    log : CSV with columns `time` (s), and for each wheel `voltage_NAME` (V), `angle_NAME` (rad) or `speed_NAME`
        (rad/s); of one motor without `_NAME`. Or a recording of a base's run.
    motor : its data sheet, for friction and inertia in N m; none unless given.
    output : folder for `drive.json`.

    Raises
    ------
    InputError
        No such log, columns that are missing, or wheels without excitation; all of them are named.
    """
    wheels, notes = _recorded(log) if log.suffix == ".mcap" else _listed(log)
    found: dict[str, DriveConstants] = {}
    refused = []
    for name, wheel in wheels.items():
        try:
            found[name] = identify_drive(wheel.time, wheel.voltage, angle=wheel.angle, speed=wheel.speed)
        except CalibrationError as error:
            refused.append(f"{name}: {error}")
    if refused:
        raise CalibrationError(f"{log}: " + "\n".join(refused))
    data: dict[str, Any] = {"log": str(log), "wheels": {name: _data(drive, motor) for name, drive in found.items()}}
    data["notes"] = list(notes)
    if output is not None:
        path = prepare_output(output) / FILE
        path.write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return Answer(_text(data), data)


def _listed(path: Path) -> tuple[dict[str, _Wheel], tuple[str, ...]]:
    """Wheels of a CSV file."""
    table = read_table(path)
    names = [name.removeprefix("voltage").removeprefix("_") for name in table.names if name.startswith("voltage")]
    if "time" not in table.names or not names:
        raise LogError(
            f"{path}:1: columns {', '.join(table.names)} came; time, and voltage_NAME with angle_NAME or speed_NAME of "
            "each wheel are expected"
        )
    time = table.column("time")
    if np.any(np.diff(time) <= 0.0):
        row = int(np.argmax(np.diff(time) <= 0.0)) + 1
        table.fault(
            row, "time", f"{time[row]:g} s after {time[row - 1]:g} s; time must grow: sort the log or cut it there"
        )
    wheels = {name or "motor": _wheel(table, name) for name in names}
    used = {"time", *(_column(kind, name) for name in names for kind in ("voltage", "angle", "speed"))}
    ignored = [name for name in table.names if name not in used]
    return wheels, (f"{path}:1: not read: column {', '.join(ignored)}",) if ignored else ()


def _wheel(table: Table, name: str) -> _Wheel:
    angle, speed = (_column(kind, name) for kind in ("angle", "speed"))
    has = [column for column in (angle, speed) if column in table.names]
    if not has:
        raise LogError(
            f"{table.path}:1: {_column('voltage', name)} came without {angle} or {speed}; record one of them"
        )
    voltage = table.column(_column("voltage", name))
    if has[0] == angle:
        return _Wheel(table.column("time"), voltage, table.column(angle), None)
    return _Wheel(table.column("time"), voltage, None, table.column(speed))


def _column(kind: str, name: str) -> str:
    return f"{kind}_{name}" if name else kind


def _recorded(path: Path) -> tuple[dict[str, _Wheel], tuple[str, ...]]:
    """Wheels of a recording of a base, by the words that it has of it."""
    try:
        pieces = read_pieces(path, lambda said, messages: None)
        for robot in dict.fromkeys(said.robot for said in pieces.topics) or [""]:
            base = base_of(pieces.metadata, robot)
            if base is not None:
                break
        else:
            raise LogError(f"{path}: no base in it; give the recording of a base's run, or a CSV file")
        recording = read_recording(path, robot=robot)
    except InputError as error:
        raise LogError(str(error)) from None
    drives, counts = recording.drives, recording.counts
    n = min(len(drives.time), len(counts.time))
    if n < 2 or not np.array_equal(drives.time[:n], counts.time[:n]):
        raise LogError(f"{path}: {len(drives.time)} samples of voltages and {len(counts.time)} of encoder counts came; "
                       "record them together")  # fmt: skip
    unit = 2.0 * math.pi / base.counts_per_turn / base.gear_ratio
    wheels = {
        name: _Wheel(drives.time[:n], drives.voltage[:n, k], unit * counts.count[:n, k].astype(np.float64), None)
        for k, name in enumerate(base.wheels)
    }
    note = (
        f"{path}: voltages as commanded at the samples; with wheels on the floor kA holds the base's share of mass, "
        "and in curves they push each other: kS and kV are rough"
    )
    return wheels, (note,)


def _data(drive: DriveConstants, motor: MotorConstants | None) -> dict[str, Any]:
    values = {name: _estimate(getattr(drive, name), unit) for name, unit in UNITS.items()}
    data: dict[str, Any] = {**values, "misfit_V": drive.misfit}
    if motor is not None:
        told: Mapping[str, Estimate] = mechanics_of(drive, motor)
        data |= {name: _estimate(told[name], unit) for name, unit in MECHANICAL.items()}
    return data


def _estimate(estimate: Estimate, unit: str) -> dict[str, Any]:
    return {"value": estimate.value, "sigma": estimate.sigma, "unit": unit}


def _text(data: Mapping[str, Any]) -> str:
    lines = []
    for name, wheel in data["wheels"].items():
        lines.append(f"{name}:")
        told = {key: value for key, value in wheel.items() if isinstance(value, dict)}
        lines += [f"  {key:16} {v['value']:12.6g} +- {v['sigma']:.2g} {v['unit']}" for key, v in told.items()]
    return "\n".join([*lines, *(f"note: {note}" for note in data["notes"])])
