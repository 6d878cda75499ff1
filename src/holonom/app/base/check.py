"""`holonom check` of a base: whether its wheels, drives, floor and path go together, without running it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from holonom.app.answer import Answer
from holonom.app.base.assembly import BaseJob, build_job
from holonom.app.base.cell_model import BaseCell
from holonom.mobile import drive_limits, dynamic_margin, rim_speeds, wheel_forces

__all__ = ["check_base"]


def check_base(cell: BaseCell, path: Path) -> Answer:
    """Check a cell by building all of it, and the path against what motors and floor can give.

    Returns
    -------
    Answer
        Length and duration of the path, the fastest wheel against its motor; warnings where the path asks for more.

    Raises
    ------
    CellError
    """
    job = build_job(cell, path)
    speed, most = wheel_speed_use(job)
    steps = np.diff(job.path.pose[:, :2], axis=0)
    length, time = float(np.hypot(*steps.T).sum()), float(job.path.time[-1])
    warnings = [*_asked(job, speed, most), *_too_late(job)]
    lines = [
        f"{path}: no errors; a path of {length:.1f} m in {time:.1f} s, wheels at up to {speed:.0f} of {most:.0f} rad/s",
        *(f"warning: {warning}" for warning in warnings),
    ]
    data = {
        "file": str(path),
        "kind": "cell",
        "path_length_m": length,
        "estimated_time_s": time,
        "peak_wheel_speed_rad_s": speed,
        "wheel_speed_limit_rad_s": most,
        "warnings": warnings,
    }
    return Answer("\n".join(lines), data)


def _asked(job: BaseJob, speed: float, most: float) -> list[str]:
    """What the path asks of motors, floor and stance that they do not have."""
    base, path = job.base, job.path
    limits = drive_limits(base, job.drive.motor, job.drive.gear, job.floor.material.peak)
    if speed > most:
        return [f"the path asks for wheels at {speed:.0f} rad/s; the motors reach {most:.0f} rad/s"]
    forces = wheel_forces(base, path.acceleration, base.mass or 0.0)
    low, high = limits.motor_limits(rim_speeds(base, path.twist))
    found = []
    for what, over in (
        ("more force than the motors have", np.maximum(forces / high, forces / low)),
        ("more force than the floor takes", np.abs(forces) / np.maximum(limits.grip(path.acceleration[:, :2]), 1e-9)),
    ):
        k, wheel = np.unravel_index(int(over.argmax()), over.shape)
        if over[k, wheel] > 1.0:
            name = base.driven[wheel]
            found.append(f"the path asks for {what}: {forces[k, wheel]:.1f} N of {name} at {path.time[k]:.2f} s")
    margin = dynamic_margin(base, path.acceleration[:, :2])
    if margin.min() < 0.0:
        found.append(
            f"the base tips over at {path.time[int(margin.argmin())]:.2f} s: brake and turn less, or build lower"
        )
    return found


def _too_late(job: BaseJob) -> list[str]:
    end = float(job.path.time[-1])
    return [
        f"fault of {fault.wheel} at {fault.time:g} s: the path is driven in {end:.1f} s"
        for fault in job.faults
        if fault.time >= end
    ]


def wheel_speed_use(job: BaseJob) -> tuple[float, float]:
    """Fastest wheel on the path, and what its motor reaches without load, rad/s."""
    speed = float(np.abs(job.base.wheel_speeds(job.path.twist)).max())
    return speed, job.drive.motor.no_load_speed / abs(job.drive.gear.ratio)
