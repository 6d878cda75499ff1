"""What a cell's base does not know of its pose: sensors, creep of its wheels, and how its loads shift."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.app.base.assembly import BaseJob
from holonom.control.base_uncertainty import UncertaintySettings
from holonom.control.path_keeping import EstimateSettings
from holonom.mobile import BaseSensors
from holonom.sim import BasePlant

__all__ = ["uncertainty"]

Array = NDArray[np.float64]

GRAVITY = 9.80665
MORE = 1.4  # creep grows faster than force where wheels push hard
PARTS = 24  # directions of acceleration that are looked at


def uncertainty(job: BaseJob) -> UncertaintySettings:
    """Return the settings for a cell's base.

    Wheels creep as on the floor's own material: by rim force over load. Force comes from acceleration (split with least
    squares, over loads that it shifts) and from the rollers' drag.
    """
    gyro, estimate = job.cell.gyro, EstimateSettings()
    ahead, left, turn = _creep(job)
    odd = 0.5 * (turn - np.roll(turn, PARTS // 2))
    even = 0.5 * (turn + np.roll(turn, PARTS // 2))
    return UncertaintySettings(
        gyro_noise=gyro.noise,
        gyro_bias=abs(gyro.bias),
        bias_time=estimate.bias_time,
        drift=BaseSensors().accelerometer_bias / estimate.bandwidth,
        drag_creep=max(ahead, left) * GRAVITY * job.drive.roller_drag,
        push_creep=(ahead, left),
        turn_square=float(np.abs(even).max()),
        turn_lean=(float(abs(odd[0])), float(abs(odd[PARTS // 4]))),
    )


def _creep(job: BaseJob) -> tuple[float, float, Array]:
    """False velocity per acceleration ahead and to the left, s; false turning (PARTS,), rad/s, at 1 m/s^2 any way."""
    plant = BasePlant(job.base, job.drive, job.floor)
    D, count = plant.rows, len(plant.rows)
    angle = 2.0 * np.pi * np.arange(PARTS) / PARTS
    a = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    force = D @ np.linalg.solve(D.T @ D, plant.mass * a)
    loads = GRAVITY * plant.support[:count, :1] - job.base.com_height * plant.support[:count, 1:] @ a[:2]
    slip = MORE * job.floor.material.creep * force / (plant.mass * loads)
    twist = np.linalg.pinv(D) @ slip
    return float(abs(twist[0, 0])), float(abs(twist[1, PARTS // 4])), (D[:, 2] @ slip) / (D[:, 2] @ D[:, 2])
