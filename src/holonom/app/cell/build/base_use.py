"""What the path of a base asks of wheels, motors, floor and stance, told without running it."""

from __future__ import annotations

from typing import Any

import numpy as np

from holonom.app.cell.build.lame import lame_warnings
from holonom.app.job import BaseJob
from holonom.mobile import drive_limits, dynamic_margin, rim_speeds
from holonom.mobile.base.wheel_base import DRAG
from holonom.mobile.drive.sharing import shared_forces
from holonom.sim import Floor
from holonom.sim.base.kernels import FOOT

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
        return _undrivable(job)
    return [*_asked(job, floor), *lame_warnings(job, floor), *_too_late(job)]


def _asked(job: BaseJob, floor: Floor) -> list[str]:
    base, path = job.base, job.task.path
    assert path is not None
    if base.steered or base.balances or any(wheel.kind == "ball" for wheel in base.wheels):
        return []
    speed, most = _wheel_speeds(job)
    if speed > most:
        return [f"the path asks for wheels at {speed:.0f} rad/s; the motors reach {most:.0f} rad/s"]
    limits = drive_limits(base, job.drive.motor, job.drive.gear, floor.material.peak)
    forces = shared_forces(base, path.acceleration, twist=path.twist)
    low, high = limits.motor_limits(rim_speeds(base, path.twist))
    centre = path.acceleration[:, :2] + path.acceleration[:, 2:] * [-base.com[1], base.com[0]]
    centre = centre - path.twist[:, 2:] ** 2 * base.com
    found = []
    for what, over in (
        ("more force than the motors have", np.maximum(forces / high, forces / low)),
        ("more force than the floor takes", np.abs(forces) / np.maximum(limits.grip(centre), 1e-9)),
    ):
        worst = over.max(axis=1)
        if worst.max() > 1.0:
            first, k = int(np.argmax(worst > 1.0)), int(worst.argmax())
            wheel = int(over[k].argmax())
            worst_of = f"most at {path.time[k]:.2f} s, {forces[k, wheel]:.1f} N of {base.driven[wheel]}"
            found.append(f"the path asks for {what}: first at {path.time[first]:.2f} s, {worst_of}")
    margin = dynamic_margin(base, centre)
    if margin.min() < -FOOT:
        first, k = int(np.argmax(margin < -FOOT)), int(margin.argmin())
        found.append(
            f"the base tips over at {path.time[first]:.2f} s (most, by {-1e3 * margin[k]:.0f} mm, at "
            f"{path.time[k]:.2f} s): brake and turn less, or build lower"
        )
    return found


def _undrivable(job: BaseJob) -> list[str]:
    """Velocities that its wheels cannot follow, and what is driven instead."""
    if job.task.velocities is None:
        return []
    found = []
    for at, *asked in job.task.velocities.tolist():
        near = job.base.feasible(asked)
        if np.abs(near - asked).max() > DRAG:
            shown = [", ".join(f"{x:.3g}" for x in twist) for twist in (asked, near)]
            found.append(f"velocity at {at:g} s: its wheels cannot follow ({shown[0]}); the nearest is ({shown[1]})")
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
