"""`holonom tune AXIS.toml`: gains of a servo axis from its sheets, verified in a simulation, and a report."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.drives.files import AxisFile, read_axis
from holonom.app.drives.tuning.tables import TuningFile, gain_unit
from holonom.closed_loop.axis_tuning import AxisLoop, AxisTuning, WantedAxis, tune_axis
from holonom.control import SERVOS, SampleTimes
from holonom.control.servo.law_design import Servo
from holonom.devices import Encoder, Gear, check_sheet
from holonom.devices.motors.sheet_check import CONTRADICTION, WARNING
from holonom.devices.motors.thermal import ThermalModel
from holonom.errors import InputError, ModelError, UnknownName
from holonom.registry import Field, parameters_of
from holonom.sim import Axis, Load

__all__ = ["axis_of", "tune_axis_file"]


def tune_axis_file(file: TuningFile, rule: str | None = None, output: Path | None = None) -> Answer:
    """Tune the axis of a file.

    Parameters
    ----------
    file : tables [motor], [supply], [gear], [load], [encoder], [sample], [wanted].
    rule : none: an axis has loops of its own.
    output : folder for report.html, tuning.json, step.csv, move.csv.

    Raises
    ------
    InputError
        A key that is unknown, missing or wrong; limits that cannot be met.
    """
    if rule is not None:
        raise ModelError(f"{file.path}: --rule {rule} came; rules are for a [process]; the loops of an axis need none")
    read = read_axis(file.path)
    axis, times, thermal = axis_of(read)
    wanted, servo = _wanted(file), _servo(file)
    try:
        found = tune_axis(axis, times=times, wanted=wanted, thermal=thermal, servo=servo)
    except InputError as problem:
        raise ModelError(f"{file.path}: {problem}") from None
    data = _data(read, found)
    if output is not None:
        from holonom.app.drives.tuning.axis_report import write_report

        folder = prepare_output(output)
        (folder / "tuning.json").write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        write_report(folder, read, found, thermal, servo, data)
    return Answer(_text(read, data), data)


def axis_of(read: AxisFile) -> tuple[Axis, SampleTimes, ThermalModel | None]:
    """The axis of a file, its sample times, and the thermal model of its motor where the sheet has one.

    Raises
    ------
    ModelError
        A table that an axis needs, or a number of its motor's sheet.
    """
    for name in ("load", "encoder"):
        if getattr(read, name) is None:
            raise ModelError(f"{read.path}: a table [{name}] is needed to tune an axis")
    assert read.load is not None
    assert read.encoder is not None
    supply, gear, sample, sheet = read.supply, read.gear, read.sample, read.motor.sheet
    try:
        motor = sheet.motor(
            max_voltage=supply.voltage if supply is not None else None,
            max_current=supply.current_limit if supply is not None else None,
        )
        axis = Axis(
            motor,
            Load(read.load.inertia or LEAST_INERTIA * motor.rotor_inertia, read.load.coulomb, read.load.viscous),
            Encoder(read.encoder.counts),
            Gear(gear.ratio, gear.efficiency) if gear is not None else Gear(1.0),
            gap=gear.gap if gear is not None else 0.0,
            stiffness=gear.stiffness if gear is not None and gear.stiffness is not None else math.inf,
        )
        times = SampleTimes(sample.current, sample.speed, sample.position) if sample is not None else SampleTimes()
    except InputError as problem:
        raise ModelError(f"{read.path}: {problem}") from None
    printed = None not in (sheet.R, sheet.Rth1, sheet.Rth2, sheet.tw, sheet.ts)
    return axis, times, sheet.thermal() if printed else None


SERVO = "servo"
"""Key of [wanted] that chooses one of `SERVOS`."""
SHOWN = (
    "resistance", "inductance", "torque_constant", "back_emf_constant", "rotor_inertia", "max_voltage", "max_current",
)  # fmt: skip
"""What is said of a motor."""
LEAST_INERTIA = 1e-6
"""Of a load that has none, part of the rotor's."""


def _wanted(file: TuningFile) -> WantedAxis:
    fields: dict[str, Field] = {field.name: field for field in parameters_of(WantedAxis)}
    try:
        return WantedAxis(**file.values("wanted", fields, (SERVO,)))
    except ModelError as problem:
        if str(file.path) in str(problem):
            raise
        raise ModelError(f"{file.place('wanted')}: {problem}") from None


def _servo(file: TuningFile) -> Servo:
    """The servo that is wanted: a name of `SERVOS`, or a table with its `kind` and parameters."""
    given = file.table("wanted").get(SERVO, "three_loops")
    params = dict(given) if isinstance(given, dict) else {"kind": given}
    name = params.pop("kind", None)
    try:
        if not isinstance(name, str):
            raise UnknownName("servo", str(name), SERVOS)
        servo: Servo = SERVOS.make(name, params)
    except InputError as problem:
        raise ModelError(f"{file.place('wanted', SERVO)}: {problem}") from None
    return servo


def _data(read: AxisFile, found: AxisTuning) -> dict[str, Any]:
    motor = found.axis.motor
    shown = {key: getattr(motor, key) for key in SHOWN}
    return {
        "motor": {"name": read.motor.title, "source": read.motor.source, **shown},
        "loops": {name: _loop(loop) for name, loop in found.loops.items()},
        "verified": {key: _finite(value) for key, value in asdict(found.verified).items()},
        "warnings": [*_contradictions(read), *(_plain(asdict(warning)) for warning in found.warnings)],
    }


def _contradictions(read: AxisFile) -> list[dict[str, Any]]:
    """What the motor's sheet says against itself: these gains are only as good as it is."""
    return [
        {"name": f.name, "text": f"the motor's sheet: {f.text}", "value": f.printed, "wanted": f.expected}
        for f in check_sheet(read.motor.sheet).findings
        if f.level in (CONTRADICTION, WARNING)
    ]


def _plain(warning: dict[str, Any]) -> dict[str, Any]:
    return {key: _finite(value) if isinstance(value, float) else value for key, value in warning.items()}


def _loop(loop: AxisLoop) -> dict[str, Any]:
    margin = loop.margin
    return {
        "form": loop.form,
        "Kc": loop.Kc,
        "Ti": loop.Ti,
        "Td": loop.Td or 0.0,
        "crossover": margin.crossover,
        "phase_margin_deg": math.degrees(margin.phase_margin),
        "gain_margin": _finite(margin.gain_margin),
        "delay": loop.delay,
    }


def _settles(time: float | None) -> str:
    return "does not settle" if time is None else f"settles in {1e3 * time:.4g} ms"


def _finite(value: float | None) -> float | None:
    """The number, None where there is none."""
    return value if value is not None and math.isfinite(value) else None


def _text(read: AxisFile, data: Mapping[str, Any]) -> str:
    lines = [f"{read.path}: {read.motor.title}"]
    for name, loop in data["loops"].items():
        Ti = "" if loop["Ti"] is None else f"  Ti {1e3 * loop['Ti']:.4g} ms"
        unit = gain_unit(name, data["loops"])
        lines.append(
            f"{name:9}{loop['form']:3} Kc {loop['Kc']:.5g} {unit}{Ti}  {loop['phase_margin_deg']:.0f} deg at "
            f"{loop['crossover'] / (2.0 * math.pi):.4g} Hz"
        )
    v = data["verified"]
    hot = v["winding_temperature"]
    lines += [
        f"step      overshoot {v['overshoot_percent']:.2g} %, {_settles(v['settling_time'])}, ripple "
        f"{v['position_ripple']:.2g} rad",
        f"move      follows within {v['following_error']:.3g} rad with {v['peak_current']:.4g} A and "
        f"{v['peak_voltage']:.4g} V"
        + ("" if hot is None else f"; without a pause its winding gets {hot:.4g} degC hot"),
    ]
    return "\n".join([*lines, *(f"warning: {w['text']}" for w in data["warnings"])])
