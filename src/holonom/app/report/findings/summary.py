"""A run in numbers, by its recording: JSON values only."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.app.report.findings.base_findings import Motion, Phase, SlipEpisode, findings_of, motion_of, path_error
from holonom.app.report.findings.facts import FieldFacts
from holonom.app.report.findings.peaks import peaks_of
from holonom.app.report.findings.tracking import compared, tracking_table
from holonom.app.report.source import BARE, RobotSource, Source
from holonom.model.joint_kinds import kind_of

__all__ = ["arm_summary", "base_summary", "placed_parts", "summary_of"]

GOOD = ("done", "paused", "unknown")
"""Endings without a failure."""
TURNS = {"speed": "rad_s", "torque": "Nm", "current": "A", "voltage": "V"}
SLIDES = {**TURNS, "speed": "m_s", "torque": "N"}


def summary_of(source: Source) -> dict[str, Any]:
    """The run: of one robot all in one table, of several a table for each under "robots"."""
    head = _head(source)
    if source.alone:
        return head | _robot(source, source.robots[0])
    parts = _parts(source) if source.cell.parts else {}
    return head | parts | {"robots": {robot.name: _robot(source, robot) for robot in source.robots}}


def _robot(source: Source, robot: RobotSource) -> dict[str, Any]:
    """What came of a robot; where that cannot be told, why not: how the run ended is not lost with it."""
    try:
        found = {"arm": arm_summary, "base": base_summary}[robot.facts.kind](source, robot)
        json.dumps(found, allow_nan=False)
    except Exception as error:  # whatever it is
        return {"model": robot.facts.model, "untold": f"{type(error).__name__}: {error}".splitlines()[0]}
    return found


def arm_summary(source: Source, robot: RobotSource) -> dict[str, Any]:
    """What came of an arm: parts placed, peaks and limits of its joints, tracking under several controllers."""
    comparison = compared(robot)
    others = [run.facts.controller for run in robot.beside.values()]
    parts = _parts(source) if source.alone else {}
    return {
        "model": robot.facts.model,
        "drives": robot.facts.drives,
        "controllers": [*others, robot.facts.controller],
        **parts,
        "largest_contact_force_N": _number(robot.numbers.get("contact_force")),
        "joints": _joints(robot),
        "tracking": None if comparison is None else tracking_table(comparison),
    }


def base_summary(source: Source, robot: RobotSource) -> dict[str, Any]:
    """What came of a base: slip and dead motors, found or not, and path errors, with those of the run beside it."""
    found = findings_of(robot.recording, robot.facts)
    motion = motion_of(robot.recording)
    bare = motion_of(robot.beside[BARE].recording) if BARE in robot.beside else None
    return {
        "model": robot.facts.model,
        "drives": robot.facts.drives,
        "path_driven": _number(robot.numbers.get("path_driven")),
        "slips": [_slip(slip) for slip in found.slips],
        "dead_motors": [asdict(motor) for motor in found.dead],
        "false_alarms": [asdict(alarm) for alarm in found.alarms],
        "path_errors": [_error(phase, motion, bare) for phase in found.phases] if motion is not None else [],
    }


def placed_parts(source: Source) -> dict[str, int]:
    """How many parts lie in each field at the end of the recording."""
    where = [_field_of(source, part.name) for part in source.cell.parts]
    return {field.name: where.count(field.name) for field in source.cell.fields}


def _head(source: Source) -> dict[str, Any]:
    ending = source.ending
    return {
        "cell": source.cell.title,
        "seed": source.cell.seed,
        "outcome": ending.status,
        "failure": None if ending.status in GOOD else ending.reason,
        "simulated_time_s": ending.simulated_time,
        "notes": list(source.cell.notes),
        "missing": list(source.lost),
    }


def _parts(source: Source) -> dict[str, Any]:
    placed, count = placed_parts(source), len(source.cell.parts)
    total = sum(placed.values())
    return {
        "parts": count,
        "placed": placed,
        "in_no_field": count - total if source.cell.fields else 0,
        "cycle_time_per_part_s": source.ending.simulated_time / total if total else None,
    }


def _field_of(source: Source, part: str) -> str | None:
    """Name of the field in which a part's centre lies at the end, None outside all of them."""
    track = source.whole.frames.get(part)
    if track is None or not len(track.time):
        return None
    return next((f.name for f in source.cell.fields if _holds(f, track.position[-1])), None)


def _holds(field: FieldFacts, place: NDArray[np.float64]) -> bool:
    T = np.array(field.T)
    x, y, z = T[:3, :3].T @ (place - T[:3, 3])
    return bool(0.0 <= x <= field.size[0] and 0.0 <= y <= field.size[1] and z < field.height)


def _joints(robot: RobotSource) -> dict[str, dict[str, float | None]]:
    peaks, facts = peaks_of(robot), robot.facts
    table: dict[str, dict[str, float | None]] = {}
    for k, (joint, kind) in enumerate(zip(facts.joints, facts.kinds, strict=True)):
        units = TURNS if kind_of(kind).turns else SLIDES
        row: dict[str, float | None] = {}
        for name, unit in units.items():
            limit = facts.limits.get(name)
            row[f"peak_{name}_{unit}"] = _number(float(peaks[name][k]))
            row[f"{name}_limit_{unit}"] = None if limit is None else limit[k]
        length = kind_of(kind).unit
        row[f"peak_error_{length}"] = _number(float(peaks["error"][k]))
        row[f"rms_error_{length}"] = _number(float(peaks["rms_error"][k]))
        table[joint] = row
    return table


def _slip(slip: SlipEpisode) -> dict[str, Any]:
    delays = {"delay": slip.delay, "naming_delay": slip.naming_delay, "right": slip.right}
    return asdict(slip) | {"named": list(slip.named)} | delays


def _error(phase: Phase, motion: Motion, bare: Motion | None) -> dict[str, Any]:
    error, other = path_error(motion, phase), path_error(bare, phase)
    return {
        "phase": phase.name,
        "start_s": phase.start,
        "end_s": phase.end,
        "rms_m": error and error.rms,
        "peak_m": error and error.peak,
        "believed_peak_m": error and error.believed,
        "heading_peak_rad": error and error.heading,
        "peak_without_handling_m": other and other.peak,
    }


def _number(value: float | None) -> float | None:
    return None if value is None or np.isnan(value) else float(value)
