"""`holonom select`: motors and gears for a load cycle, ranked, rejections explained."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from holonom.app.console.answer import Answer
from holonom.app.drives.arm_cycle import cycles_of_cell, cycles_of_recording
from holonom.app.drives.cycle_file import Candidates, read_cycle, standard_candidates
from holonom.app.drives.files import is_cell
from holonom.devices import Choice, LoadCycle, best_ratio, check_sheet, select_drive
from holonom.errors import InputError

__all__ = ["select"]


def select(path: Path, *, joint: str | None = None, arm: str | None = None, quiet: bool = True) -> Answer:
    """Select drives for a cycle file, or for joints of an arm from its own motion.

    Parameters
    ----------
    path : of a load cycle (TOML), a recording (.mcap) or a cell (TOML).
    joint : name or number of a joint, or "all"; of a recording or cell.
    arm : preset or URDF file of a recorded arm.
    quiet : no progress bar while a cell is run.

    Raises
    ------
    InputError
        What cannot be read or is missing. Of a cell also what `run_cell` raises.
    """
    recording = path.suffix.lower() == ".mcap"
    if recording or is_cell(path):
        if joint is None:
            raise InputError(f"{path}: which joint? give --joint NAME, its number, or all")
        found = cycles_of_recording(path, joint, arm) if recording else cycles_of_cell(path, joint, quiet=quiet)
        return _of_joints(path, *found)
    if joint is not None or arm is not None:
        raise InputError(f"{path}: --joint and --arm belong to a recording (.mcap) or a cell; this is a load cycle")
    asked = read_cycle(path)
    data: dict[str, Any] = {"file": str(path)}
    lines = []
    if asked.inertias is not None:
        data["ratio"] = best_ratio(*asked.inertias)
        lines.append(f"ratio with the greatest acceleration: {data['ratio']:.5g}")
    if asked.cycle is not None:
        told, text = _selected(asked.cycle, asked.candidates)
        data, lines = data | told, [*lines, *text]
    data["assumed"] = list(asked.candidates.assumed) if asked.cycle is not None else []
    data["warnings"] = [
        {"name": f.name, "text": f"{card.title}: {f.text}", "value": f.printed, "wanted": f.expected}
        for card in asked.candidates.motors
        for f in check_sheet(card.sheet).contradictions
    ]
    lines += [f"warning: {warning['name']}: {warning['text']}" for warning in data["warnings"]]
    return Answer("\n".join([*lines, *(f"assumed: {said}" for said in data["assumed"])]), data)


def _of_joints(path: Path, cycles: dict[str, LoadCycle], notes: Sequence[str]) -> Answer:
    candidates = standard_candidates()
    joints, lines = {}, []
    for name, cycle in cycles.items():
        joints[name], text = _selected(cycle, candidates)
        lines += [f"{name}:", *(f"  {line}" for line in text)]
    lines += [f"note: {note}" for note in notes] + [f"assumed: {said}" for said in candidates.assumed]
    data = {"file": str(path), "joints": joints, "notes": list(notes), "assumed": list(candidates.assumed)}
    return Answer("\n".join(lines), data)


def _selected(cycle: LoadCycle, candidates: Candidates) -> tuple[dict[str, Any], list[str]]:
    fitting, others = select_drive(cycle, candidates.motors, candidates.gears, candidates.limits)
    data = {
        "time": cycle.time,
        "acceleration": float(np.abs(cycle.acceleration).max()),
        "peak_speed": cycle.peak_speed,
        "peak_torque": cycle.peak_torque,
        "rms_torque": cycle.rms_torque,
        "inertia": cycle.inertia,
        "ranked": [_told(choice) for choice in fitting],
        "rejected": [_told(choice) for choice in others],
    }
    head = (
        f"a cycle of {cycle.time:.4g} s: up to {cycle.peak_speed:.4g} rad/s, {cycle.peak_torque:.4g} N m, "
        f"{cycle.rms_torque:.4g} N m rms"
    )
    lines = [head, "motors that make it, the smallest first:" if fitting else "no motor makes it"]
    lines += [f"  {_line(choice)}" for choice in fitting]
    for choice in others:
        reasons = "; ".join(f"{one.name}: {one.text}" for one in choice.rejections)
        lines.append(f"rejected: {choice.motor.title} with {choice.gear.ratio:g}:1: {reasons}")
    return data, lines


def _line(choice: Choice) -> str:
    heat = f", winding {choice.winding_temperature:.0f} degC" if choice.winding_temperature > 0.0 else ""
    return (
        f"{choice.motor.title} with {choice.gear.ratio:g}:1: {100.0 * choice.used:.0f} % of its limits, "
        f"{choice.rms_current:.3g} A rms, {choice.peak_current:.3g} A peak, {choice.peak_speed:.4g} rad/s{heat}"
    )


def _told(choice: Choice) -> dict[str, Any]:
    numbers = {
        "peak_torque": choice.peak_torque,
        "rms_torque": choice.rms_torque,
        "peak_current": choice.peak_current,
        "rms_current": choice.rms_current,
        "peak_speed": choice.peak_speed,
        "peak_voltage": choice.peak_voltage,
        "inertia_ratio": choice.inertia_ratio,
        "best_ratio": choice.best_ratio,
        "thermal_limit": choice.thermal_limit or None,
        "nominal_current": choice.nominal_current or None,
        "winding_temperature": choice.winding_temperature or None,
        "used": choice.used,
    }
    finite = {key: value if value is not None and math.isfinite(value) else None for key, value in numbers.items()}
    return {
        "motor": choice.motor.name,
        "title": choice.motor.title,
        "gear": choice.gear.name,
        "ratio": choice.gear.ratio,
        **finite,
        "rejections": [
            {"name": one.name, "text": one.text, "value": one.value, "limit": one.limit} for one in choice.rejections
        ],
    }
