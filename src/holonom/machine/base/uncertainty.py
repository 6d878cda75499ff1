"""What a base's controller does not know of its pose: sensors, creep of its wheels, and how its loads shift."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.control.base.path_keeping import EstimateSettings
from holonom.control.base.uncertainty import UncertaintySettings
from holonom.machine.base.settings import Creep
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import (
    GRAVITY,
    BaseDrive,
    BaseSensors,
    base_mass,
    rest_loads,
    roller_cosines,
    supports,
)
from holonom.mobile.drive.coupling import base_twist
from holonom.mobile.drive.sharing import shared_forces
from holonom.numeric.contact_loads import pushing_loads

__all__ = ["pose_uncertainty"]


MORE = 1.4  # creep grows faster than force where wheels push hard
LEAST_SHARE = 1e-3  # of the weight, that a wheel counts for at least
PARTS = 24  # directions of acceleration that are looked at


def pose_uncertainty(
    base: WheelBase, drive: BaseDrive, sensors: BaseSensors, creep: Creep, estimate: EstimateSettings
) -> UncertaintySettings:
    """Return the settings of the covariance of a base's dead reckoning.

    Wheels creep by rim force over load. Force comes from acceleration (split by what each wheel carries, over loads
    that it shifts) and from the rollers' drag.
    """
    ahead, left, turn = _creep(base, creep.slope)
    odd = 0.5 * (turn - np.roll(turn, PARTS // 2))
    even = 0.5 * (turn + np.roll(turn, PARTS // 2))
    return UncertaintySettings(
        gyro_noise=sensors.gyro_noise,
        gyro_bias=abs(sensors.gyro_bias),
        bias_time=estimate.bias_time,
        drift=abs(sensors.accelerometer_bias) / estimate.bandwidth,
        drag_creep=max(ahead, left) * GRAVITY * drive.roller_drag,
        force_creep=(ahead, left),
        turn_square=float(np.abs(even).max()),
        turn_lean=(float(abs(odd[0])), float(abs(odd[PARTS // 4]))),
    )


def _creep(base: WheelBase, slope: float) -> tuple[float, float, Array]:
    """False velocity per acceleration ahead and to the left, s; false turning (PARTS,), rad/s, at 1 m/s^2 any way."""
    if base.steered or len(base.driven) != sum(wheel.driven for wheel in base.wheels):
        creep = MORE * slope / GRAVITY  # every wheel uses the part of its grip that the base uses of its weight
        return creep, creep, np.zeros(PARTS)
    D, mass = base.velocity_coupling * [1.0, 1.0, base.radius], base_mass(base)
    angle = 2.0 * np.pi * np.arange(PARTS) / PARTS
    a = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    force = shared_forces(base, a.T).T
    at, count = supports(base), len(D)
    shares, stands = pushing_loads(at, -base.com_height / GRAVITY * a[:2].T)
    loads = np.where(stands[:, None], mass * GRAVITY * shares[:, :count], rest_loads(base))  # one that tips: as at rest
    least = np.maximum(loads.T, LEAST_SHARE * mass * GRAVITY)
    slip = MORE * slope * force / least / roller_cosines(base)[:, None] ** 2
    twist = base_twist(base, slip.T).T
    return float(abs(twist[0, 0])), float(abs(twist[1, PARTS // 4])), (D[:, 2] @ slip) / (D[:, 2] @ D[:, 2])
