"""What motors that are left can hold of a path once others have died, told without running it."""

from __future__ import annotations

import numpy as np

from holonom.app.job import BaseJob
from holonom.mobile import drive_limits, rim_speeds
from holonom.mobile.drive.coupling import coupling_of
from holonom.mobile.drive.failed_motor import motors_hold_all
from holonom.sim import Floor

__all__ = ["lame_warnings"]

FIRST = 1e4  # weight of what is kept over what is given up
STEP = 0.01  # s
SPARE = 0.02  # of a limit, by which it may be passed: rounding and the path's own samples


def lame_warnings(job: BaseJob, floor: Floor) -> list[str]:
    """Motors without which the others cannot hold path and heading, or what the cell chose of them."""
    base, lost, found = job.base, 0, []
    if base.steered:
        return []
    for fault in sorted(job.faults, key=lambda fault: fault.time):
        if fault.kind == "stuck":
            continue
        wheel = base.driven.index(fault.wheel) if isinstance(fault.wheel, str) else fault.wheel
        lost |= 1 << wheel
        if fault.kind != "dead" or motors_hold_all(base, lost):
            continue
        start = f"without the motor of {base.driven[wheel]}, from {fault.time:g} s on, the others cannot hold"
        if job.settings.keep == "both":
            found.append(
                f'{start} path and heading at once; keep = "path" or "heading" in its path chooses, else both are asked'
            )
            continue
        limit = _first_limit(job, floor, lost, fault.time - job.task.start)
        if limit:
            found.append(f"{start} the {job.settings.keep} as fast as it is asked for: {limit}; drive slower")
    return found


def _first_limit(job: BaseJob, floor: Floor, lost: int, since: float) -> str:
    """First moment at which a motor or the floor has not the force for what is kept; "" where all goes well.

    Newton's law along the path: forces of the least square sum that give the kept part of its acceleration, and what
    they can of the rest; what is given up runs as it will, and the wheels with it.
    """
    path, base, coupling = job.task.path, job.base, coupling_of(job.base)
    assert path is not None
    live = np.array([not (lost >> k) & 1 for k in range(coupling.wheels)])
    if not live.any():
        return "no motor is left"
    mass, R = base.mass or 1.0, coupling.radius
    C = coupling.force[:, live] / mass
    weight = np.array([FIRST, FIRST, 1.0]) if job.settings.keep == "path" else np.array([1.0, 1.0, FIRST])
    share = np.linalg.pinv(weight[:, None] * C, rcond=1e-9 / FIRST) * weight
    kept = slice(0, 2) if job.settings.keep == "path" else slice(2, 3)
    limits = drive_limits(base, job.drive.motor, job.drive.gear, floor.material.peak)
    grip = np.asarray(limits.grip(np.zeros(2)))
    time = np.arange(max(since, 0.0), float(path.time[-1]), STEP)
    if not len(time):
        return ""
    pose, twist, wanted = (
        np.column_stack([np.interp(time, path.time, column) for column in rows.T])
        for rows in (np.column_stack([path.pose[:, :2], np.unwrap(path.pose[:, 2])]), path.twist, path.acceleration)
    )
    heading, state = float(pose[0, 2]), _turned(twist[0], float(pose[0, 2]))  # vx, vy of the world, w
    for k, now in enumerate(time):
        asked = _turned(_turned(wanted[k], float(pose[k, 2])), -heading) * [1.0, 1.0, R]
        forces = np.zeros(coupling.wheels)
        forces[live] = share @ asked
        given = C @ forces[live]
        rims = rim_speeds(base, _turned(state, -heading))
        low, high = limits.motor_limits(rims)
        over = np.where(live, np.abs(forces) / np.maximum(grip, 1e-9), 0.0)
        weak = live & ((forces > high * (1.0 + SPARE) + 1e-3) | (forces < low * (1.0 + SPARE) - 1e-3))
        missed = float(np.abs((asked - given)[kept]).max())
        if missed > SPARE * max(float(np.abs(wanted[:, :2]).max()), 1e-3):
            return f"at {now:.2f} s they push in no direction that would be needed"
        for what, which in (("the motor", weak), ("the floor", over > 1.0 + SPARE)):
            if which.any():
                wheel = int(np.argmax(which))
                return (
                    f"at {now:.2f} s {abs(forces[wheel]):.1f} N of {base.driven[wheel]} at {abs(rims[wheel]):.2f} m/s "
                    f"are more than {what} has"
                )
        state = state + STEP * _turned(given / [1.0, 1.0, R], heading)
        heading += STEP * float(state[2])
    return ""


def _turned(twist: np.ndarray, angle: float) -> np.ndarray:
    """First two components turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[2]])
