"""`holonom check` of a base: whether its wheels, drives, floor and path go together, without running it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from holonom.app.answer import Answer
from holonom.app.base.assembly import BaseJob, build_job
from holonom.app.base.cell_model import BaseCell

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
    warnings = []
    if speed > most:
        warnings.append(f"the path asks for wheels at {speed:.0f} rad/s; the motors reach {most:.0f} rad/s")
    grip = cell.floor.friction * 9.81
    asked = float(np.hypot(*job.path.acceleration[:, :2].T).max())
    if asked > grip:
        warnings.append(f"the path asks for {asked:.1f} m/s2; friction {cell.floor.friction:g} allows {grip:.1f} m/s2")
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


def wheel_speed_use(job: BaseJob) -> tuple[float, float]:
    """Fastest wheel on the path, and what its motor reaches without load, rad/s."""
    speed = float(np.abs(job.base.wheel_speeds(job.path.twist)).max())
    return speed, job.drive.motor.no_load_speed / abs(job.drive.gear.ratio)
