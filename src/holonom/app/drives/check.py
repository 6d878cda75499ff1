"""`holonom check` of a motor or an axis: identities of its sheet, contradictions, limits that do not fit together."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from holonom.app.console.answer import Answer
from holonom.app.drives.files import AxisFile, is_other_motor, read_axis
from holonom.app.drives.other_motors import check_other_motor
from holonom.devices import DcMotor, Finding, best_ratio, check_sheet
from holonom.devices.motors.sheet_check import CONTRADICTION, NOTE, WARNING
from holonom.errors import InputError

__all__ = ["check_drive"]

COARSE = 0.02
"""Part of the no-load speed that one count a sample may be."""
UNEVEN = 10.0
"""Load's inertia over the rotor's, at the motor, from which an axis is hard to hold stiffly."""


def check_drive(path: Path) -> Answer:
    """Check the file of a motor or an axis.

    Returns
    -------
    Derived values and findings; status 2 where numbers contradict each other.

    Raises
    ------
    ModelError
        What cannot be read, a line for each fault.
    """
    if is_other_motor(path):
        return check_other_motor(path)
    axis = read_axis(path)
    checked = check_sheet(axis.motor.sheet)
    findings = [*checked.findings, *_axis(axis)]
    by_level = {level: [f for f in findings if f.level == level] for level in (CONTRADICTION, WARNING, NOTE)}
    data: dict[str, Any] = {"file": str(path), "kind": axis.kind, "motor": axis.motor.title, **checked.derived}
    data |= {
        "source": axis.motor.source,
        "assumed": axis.motor.assumed,
        "contradictions": [_told(f) for f in by_level[CONTRADICTION]],
        "warnings": [_told(f) for f in by_level[WARNING]],
        "notes": [_told(f) for f in by_level[NOTE]],
    }
    return Answer(_text(path, axis, checked.derived, by_level), data, 2 if by_level[CONTRADICTION] else 0)


def _told(finding: Finding) -> dict[str, Any]:
    told = asdict(finding)
    del told["level"]
    return told


def _text(path: Path, axis: AxisFile, derived: dict[str, float], by_level: dict[str, list[Finding]]) -> str:
    wrong = by_level[CONTRADICTION]
    verdict = f"{len(wrong)} contradictions" if len(wrong) > 1 else "1 contradiction" if wrong else "no contradiction"
    lines = [f"{path}: {axis.motor.title}: {verdict}"]
    lines += [f"  {key:34} {value:12.6g}" for key, value in derived.items()]
    lines += [f"{level}: {f.name}: {f.text}" for level, findings in by_level.items() for f in findings]
    if axis.motor.assumed:
        lines.append(f"assumed: {axis.motor.assumed}")
    return "\n".join(lines)


def _axis(axis: AxisFile) -> Iterator[Finding]:
    """What the parts of an axis say of each other."""
    if axis.kind == "motor":
        return
    supply = axis.supply
    voltage = supply.voltage if supply is not None else None
    current = supply.current_limit if supply is not None else None
    try:
        motor = axis.motor.sheet.motor(max_voltage=voltage, max_current=current)
    except InputError as problem:
        yield Finding("no motor", WARNING, f"{problem}; the axis was not checked", 0.0, 0.0)
        return
    yield from _power(axis, motor, current)
    yield from _load(axis, motor)
    yield from _samples(axis, motor)


def _power(axis: AxisFile, motor: DcMotor, current: float | None) -> Iterator[Finding]:
    sheet = axis.motor.sheet
    if current is not None and sheet.I_demag is not None and current > sheet.I_demag:
        text = f"the power stage gives {current:g} A, {sheet.I_demag:g} A weaken the magnets for ever"
        yield Finding("current limit above the demagnetising current", CONTRADICTION, text, current, sheet.I_demag)
    if current is not None and None not in (sheet.R, sheet.Rth1, sheet.Rth2, sheet.tw, sheet.ts):
        model = sheet.thermal()
        if current > model.largest_current():
            after = model.time_to(current)
            text = (
                f"the power stage gives {current:g} A, the winding bears {model.largest_current():.4g} A for ever; "
                f"cold, it is at {model.limit:g} degrees after {after:.4g} s"
            )
            yield Finding("current limit above the thermal limit", NOTE, text, current, model.largest_current())
    fastest = (sheet.n_max or math.inf) * math.pi / 30.0
    if motor.no_load_speed > fastest:
        text = f"the supply turns the free motor at {motor.no_load_speed:.4g} rad/s; n_max is {fastest:.4g} rad/s"
        yield Finding("supply above the largest speed", WARNING, text, motor.no_load_speed, fastest)


def _load(axis: AxisFile, motor: DcMotor) -> Iterator[Finding]:
    gear, load = axis.gear, axis.load
    ratio = abs(gear.ratio) if gear is not None else 1.0
    efficiency = gear.efficiency if gear is not None else 1.0
    if ratio == 0.0:
        yield Finding("gear ratio 0", CONTRADICTION, "a gear has motor turns per turn of the load, not 0", 0.0, 1.0)
        return
    most = motor.torque_constant * min(motor.max_current, motor.max_voltage / motor.resistance)
    if load is not None:
        needed = load.coulomb / (ratio * efficiency)
        if needed >= most:
            text = f"friction takes {needed:.4g} N m at the motor, which makes {most:.4g} N m at most: it does not move"
            yield Finding("friction above the torque", CONTRADICTION, text, needed, most)
        part = (load.inertia or 0.0) / ratio**2 / motor.rotor_inertia
        if load.inertia is not None and part > UNEVEN:
            best = best_ratio(motor.rotor_inertia, load.inertia)
            text = (
                f"the load's inertia is {part:.4g} times the rotor's at the motor; with a ratio of {best:.4g} it would "
                "be the same, and the acceleration the greatest"
            )
            yield Finding("inertia ratio", WARNING, text, part, UNEVEN)
    speed = axis.wanted.speed if axis.wanted is not None else None
    if speed is not None and speed * ratio > motor.no_load_speed:
        text = f"{speed:g} rad/s are wanted at the load, {motor.no_load_speed / ratio:.4g} rad/s are there without any"
        yield Finding("speed above the no-load speed", CONTRADICTION, text, speed, motor.no_load_speed / ratio)


def _samples(axis: AxisFile, motor: DcMotor) -> Iterator[Finding]:
    sample, encoder = axis.sample, axis.encoder
    if sample is not None and sample.current > motor.electrical_time_constant:
        text = (
            f"the current is sampled every {1e6 * sample.current:.4g} us, L/R is "
            f"{1e6 * motor.electrical_time_constant:.4g} us; between samples it runs away: sample "
            f"every {1e5 * motor.electrical_time_constant:.3g} us, or add inductance"
        )
        yield Finding("sample time above L/R", WARNING, text, sample.current, motor.electrical_time_constant)
    if encoder is not None:
        every = sample.speed if sample is not None else 5e-4
        step = 2.0 * math.pi / (encoder.counts * every)
        if step > COARSE * motor.no_load_speed:
            needed = math.ceil(2.0 * math.pi / (every * COARSE * motor.no_load_speed))
            part = 100.0 * step / motor.no_load_speed
            text = (
                f"one count in {1e3 * every:.3g} ms is {step:.4g} rad/s, {part:.3g} % of the no-load speed; "
                f"{needed} counts make it {100.0 * COARSE:g} %"
            )
            yield Finding("encoder too coarse", WARNING, text, float(encoder.counts), float(needed))
