"""What the path of a base asks of wheels, motors, floor and stance, told without running it."""

from __future__ import annotations

from typing import Any

import numpy as np

from holonom.app.job import BaseJob
from holonom.mobile import drive_limits, dynamic_margin, rim_speeds, wheel_forces
from holonom.sim import Floor

__all__ = ["path_use", "path_warnings"]


def path_use(job: BaseJob) -> dict[str, Any]:
    """Length and duration of the path of a base, the fastest wheel on it and what its motor reaches without load."""
    path = job.task.path
    assert path is not None
    steps = np.diff(path.pose[:, :2], axis=0)
    speed, most = _wheel_speeds(job)
    return {
        "path_length_m": float(np.hypot(*steps.T).sum()),
        "estimated_time_s": float(path.time[-1]),
        "peak_wheel_speed_rad_s": speed,
        "wheel_speed_limit_rad_s": most,
    }


def path_warnings(job: BaseJob, floor: Floor) -> list[str]:
    """What the path asks of motors, floor and stance that they do not have; faults that come too late."""
    if job.task.path is None:
        return []
    return [*_asked(job, floor), *_too_late(job)]


def _asked(job: BaseJob, floor: Floor) -> list[str]:
    base, path = job.base, job.task.path
    assert path is not None
    if base.steered:
        return []
    speed, most = _wheel_speeds(job)
    if speed > most:
        return [f"the path asks for wheels at {speed:.0f} rad/s; the motors reach {most:.0f} rad/s"]
    limits = drive_limits(base, job.drive.motor, job.drive.gear, floor.material.peak)
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
    assert job.task.path is not None
    end = job.task.start + float(job.task.path.time[-1])
    return [
        f"fault of {fault.wheel} at {fault.time:g} s: the path is driven in {end:.1f} s"
        for fault in job.faults
        if fault.time >= end and job.task.after is None
    ]


def _wheel_speeds(job: BaseJob) -> tuple[float, float]:
    """Fastest wheel on the path, and what its motor reaches without load, rad/s."""
    path = job.task.path
    assert path is not None
    moving = path.twist[np.abs(path.twist).max(axis=1) > 1e-3]
    speed = float(np.abs(job.base.wheel_speeds(moving)).max(initial=0.0))
    return speed, job.drive.motor.no_load_speed / abs(job.drive.gear.ratio)
