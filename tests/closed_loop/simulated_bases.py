"""Bases, drives and floors that the tests of the simulated base share."""

from __future__ import annotations

import numpy as np

from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.mobile.arrangements import differential, mecanum, omni
from holonom.mobile.base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive

# A RoboCup robot: mass, size, gear, wheel radius and inertia of a public model (robocup_model_params of the reference
# data); motor of the 30 W flat class, assumed.
MOTOR = DcMotor(1.2, 0.56e-3, 25.5e-3, 25.5e-3, 9.25e-6, 14.8, 8.0)
DRIVE = BaseDrive(MOTOR, Gear(3.0, 0.9), Encoder(4096), Friction(2e-6, 2e-3, 2e-3), 2.516704e-5)
LOSSLESS = BaseDrive(MOTOR, Gear(3.0), Encoder(4096), Friction(), 2.516704e-5, roller_drag=0.0)


def soccer(**changes: float) -> WheelBase:
    """Wheels front left, rear left, rear right, front right: axles 33 (front) and 45 degrees off the lateral axis."""
    body = {"radius": 0.0789, "wheel_radius": 0.02711, "alpha": 0.5, "mass": 6.35, "com_height": 0.04} | changes
    return omni(angles=np.deg2rad([57.0, 135.0, 225.0, 303.0]), **body)  # type: ignore[arg-type]


BASES = {
    "omni 4": soccer(),
    "omni 3": omni(n=3, radius=0.0789, wheel_radius=0.02711, alpha=0.5, mass=6.35, com_height=0.04),
    "omni 6": omni(n=6, radius=0.0789, wheel_radius=0.02711, alpha=0.5, mass=6.35, com_height=0.04),
    "mecanum": mecanum(0.2, 0.16, 0.03, mass=6.35, com_height=0.04),
    "differential": differential(0.16, 0.03, mass=6.35),
}
