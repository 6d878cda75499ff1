"""The report of a base: map, faults and what was found of them, polar plots, curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from holonom.app.base.assembly import BaseJob
from holonom.app.base.outcome import DeadMotor, FalseAlarm, PathError, Phase, SlipEpisode
from holonom.app.base.scene import build_scene, patch_corners
from holonom.app.recording import read_recording
from holonom.app.report import (
    Curve,
    Figures,
    LimitUse,
    MapLine,
    MapMark,
    MapPatch,
    Outcome,
    Polar,
    PolarLine,
    Table,
    TopView,
    write_report,
)
from holonom.closed_loop import BaseLog
from holonom.mobile import Envelope, SlipStatus, acceleration_envelope, drive_limits, effective_motors, speed_envelope

__all__ = ["Findings", "write_base_report"]

Array = NDArray[np.float64]

REFERENCE, TRUE, BELIEVED, BARE = "#16202e", "#0f766e", "#8f7ae0", "#f0a37f"
INTACT, DEAD = "#0b7285", "#d9480f"
PATCH, MARK = "#bfe3f5", "#b3261e"


@dataclass(frozen=True, slots=True)
class Findings:
    """What came of a run, and of the same run without any handling of faults.

    `failure` says why it did not get to its end; `errors` are the phases with the path errors of both runs.
    """

    log: BaseLog
    bare: BaseLog
    failure: str | None
    slips: Sequence[SlipEpisode]
    dead: Sequence[DeadMotor]
    alarms: Sequence[FalseAlarm]
    errors: Sequence[tuple[Phase, PathError | None, PathError | None]]


def write_base_report(path: Path, job: BaseJob, found: Findings, recording: Path, facts: dict[str, str]) -> None:
    """Write the report beside its recording."""
    cell, log = job.cell, found.log
    worst = 1e3 * log.path_error.max()
    write_report(
        path,
        read_recording(recording),
        build_scene(cell, job.base, log.reference_pose[:, :2]),
        title=cell.cell.name,
        subtitle=cell.cell.description,
        outcome=Outcome(found.failure is None, found.failure or f"path driven, at most {worst:.0f} mm off"),
        facts=facts,
        curves=_curves(log, found.bare),
        figures=[_map(job, found), _faults(found), _polar(job, found)],
        limits=_limits(job, log),
    )


def _map(job: BaseJob, found: Findings) -> Figures:
    log, bare = found.log, found.bare
    lines = [
        MapLine("without handling of faults", bare.pose[:, :2], BARE),
        MapLine("driven", log.pose[:, :2], TRUE),
        MapLine("where the controller believed to be", log.estimated_pose[:, :2], BELIEVED),
        MapLine("reference", log.reference_pose[:, :2], REFERENCE, dashed=True),
    ]
    marks = [MapMark(f"{slip.wheel} slips", _place(log, slip.start), MARK) for slip in found.slips]
    marks += [
        MapMark(f"motor of {motor.wheel} {motor.kind}", _place(log, motor.time), MARK)
        for motor in found.dead
        if motor.reached
    ]
    patches = [MapPatch(patch.name, patch_corners(patch), PATCH) for patch in job.cell.floor.patches]
    head = ("phase", "from", "to", "rms", "peak", "peak, believed", "heading, peak", "peak without handling")
    table = Table(head, [_phase_row(*row) for row in found.errors])
    note = (
        "Distance of the true pose from where the reference is at the same instant. The controller knows its pose by "
        "dead reckoning only; what it believes its error to be is the believed peak, the rest is drift."
    )
    return Figures("path", "Path", [TopView("seen from above", lines, patches, marks), table], note)


def _phase_row(phase: Phase, error: PathError | None, bare: PathError | None) -> tuple[str, ...]:
    times = (phase.name, f"{phase.start:.2f} s", f"{phase.end:.2f} s")
    other = "ended before" if bare is None else f"{1e3 * bare.peak:.1f} mm"
    if error is None:
        return (*times, "", "", "", "", other)
    distances = (f"{1e3 * value:.1f} mm" for value in (error.rms, error.peak, error.believed))
    return (*times, *distances, f"{np.degrees(error.heading):.1f}°", other)


def _place(log: BaseLog, time: float) -> tuple[float, float]:
    k = min(int(np.searchsorted(log.time, time)), len(log.time) - 1)
    return float(log.pose[k, 0]), float(log.pose[k, 1])


def _faults(found: Findings) -> Figures:
    head = ("what happened", "since", "found after", "named after", "named")
    rows = [
        (
            f"{slip.wheel} slips, up to {slip.peak:.2f} m/s",
            f"{slip.start:.3f} s",
            _after(slip.delay),
            _after(slip.naming_delay) if slip.delay is not None else "",
            " and ".join(slip.named) or ("ambiguous" if slip.detected is not None else ""),
        )
        for slip in found.slips
    ]
    rows += [
        (
            f"motor of {motor.wheel} {motor.kind}",
            f"{motor.time:.3f} s",
            _after(None if motor.detected is None else motor.detected - motor.time)
            if motor.reached
            else "the run ended before",
            "",
            motor.wheel if motor.detected is not None else "",
        )
        for motor in found.dead
    ]
    rows += [(alarm.what, f"{alarm.start:.3f} s", "", "", f"until {alarm.end:.3f} s") for alarm in found.alarms]
    note = (
        "The controller knows encoders, motor currents, gyro and accelerometers only; it is told of no fault. "
        "A wheel slips here from the slip on at which friction peaks."
    )
    return Figures("faults", "Faults, and what was found of them", [Table(head, rows)], note)


def _after(delay: float | None) -> str:
    return "never" if delay is None else f"{1e3 * delay:.0f} ms"


def _polar(job: BaseJob, found: Findings) -> Figures:
    directions = np.linspace(0.0, 2.0 * np.pi, 181)
    dead = [motor.wheel for motor in found.dead if motor.reached]
    out = [found.log.wheels.index(wheel) for wheel in dead]
    base = job.base
    limits = drive_limits(base, job.drive.motor, job.drive.gear, job.floor.material.peak)

    def plot(title: str, unit: str, values: Array, without: Array | None) -> Polar:
        lines = [PolarLine("all motors", directions, values, INTACT)]
        if without is not None:
            lines.append(PolarLine(f"without {' and '.join(dead)}", directions, without, DEAD))
        return Polar(title, unit, lines)

    def value(envelope: Envelope) -> Array:
        return envelope.value

    motors = effective_motors(base, directions)
    acceleration = value(acceleration_envelope(base, directions, limits))
    speed = value(speed_envelope(base, directions, limits))
    figures = [
        plot("effective motors", "", motors, effective_motors(base, directions, out=out) if out else None),
        plot(
            "largest acceleration", "m/s²", acceleration,
            value(acceleration_envelope(base, directions, limits, out=out)) if out else None,
        ),
        plot("largest speed", "m/s", speed, value(speed_envelope(base, directions, limits, out=out)) if out else None),
    ]  # fmt: skip
    note = "By direction of travel in the robot frame, without turning: what motors and floor can give."
    return Figures("polar", "What the drive can do", figures, note)


def _curves(log: BaseLog, bare: BaseLog) -> list[Curve]:
    names, t = log.wheels, log.time
    status = np.stack([log.status == SlipStatus.SLIP, log.status == SlipStatus.AMBIGUOUS, log.dead.any(axis=1)], axis=1)
    return [
        Curve("path_error", "Path error", "mm", t, 1e3 * log.path_error[:, None], ("distance",)),
        Curve(
            "bare_error", "Path error without handling", "mm", bare.time, 1e3 * bare.path_error[:, None], ("distance",)
        ),
        Curve("residual", "Rim speed that no twist explains", "m/s", t, log.residuals, names),
        Curve("slip", "Slip, true", "m/s", t, log.slip, names),
        Curve(
            "status", "What the controller found", "", t, status.astype(float), ("slip, named", "slip", "dead motor")
        ),
        Curve("force", "Driving force", "N", t, log.forces, names),
        Curve("speed", "Wheel speed", "rad/s", t, log.wheel_speeds, names),
        Curve("current", "Motor current", "A", t, log.currents, names),
    ]


def _limits(job: BaseJob, log: BaseLog) -> list[LimitUse]:
    motor, gear = job.drive.motor, job.drive.gear
    count = len(log.wheels)

    def use(name: str, unit: str, values: Array, limit: float) -> LimitUse:
        return LimitUse(name, unit, np.abs(values).max(axis=0), np.full(count, limit))

    grip = np.abs(log.forces) / np.maximum(log.friction_limits, 1e-9)
    return [
        use("Wheel speed", "rad/s", log.wheel_speeds, motor.no_load_speed / abs(gear.ratio)),
        use("Motor current", "A", log.currents, motor.max_current),
        use("Motor voltage", "V", log.voltages, motor.max_voltage),
        use("Share of the friction limit", "", grip, 1.0),
    ]
