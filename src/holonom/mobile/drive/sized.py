"""Drives for a base that states none: motor, gear and encoder of each wheel, sized from what the base is to reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from holonom.devices import DcMotor, Encoder, Gear, SteeringMotor
from holonom.errors import ModelError
from holonom.mechanics.arm.sized_drives import sized_motor
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import GRAVITY, BaseDrive

__all__ = ["sized_base_drive", "usual_steering"]

SUPPLY = 24.0
"""V, of a battery."""
WHEEL_DENSITY = 1500.0
"""kg/m3 of a drawn wheel, a cylinder as wide as its radius."""
WHEELS = 0.5  # of a base's mass, that its wheels weigh together at most
SWINGING = 1.5
"""Rate at which driven castors can swing over speed by lever: for a base that turns at once."""
GRIP = 0.8  # of a dry floor
RESERVE = 2.0
"""Force of the wheels over what the acceleration takes: for turning at once, friction and a wheel that slips."""


def sized_base_drive(base: WheelBase, speed: float, acceleration: float) -> BaseDrive:
    """Return what drives each wheel of a base, so that it reaches a speed (m/s) and an acceleration (m/s2).

    The fastest wheel is that of a base which moves at `speed` in any direction, or turns so fast that its rim does;
    each motor's torque limit gives twice its share of the force, and what drags skidding wheels across as it turns.

    Raises
    ------
    ModelError
        A base without mass, a speed or acceleration that is not positive.
    """
    if base.mass is None:
        raise ModelError(f"base {base.name!r} has no mass, so its drives cannot be sized; state mass= in kg")
    if not (speed > 0.0 and acceleration > 0.0):
        raise ModelError(f"speed {speed!r} m/s and acceleration {acceleration!r} m/s2 came; both must be positive")
    radius = float(np.min(base.wheel_radii))
    wheel_speed = speed * _gearing(base) / radius
    torque = base.mass * (RESERVE * acceleration + _dragging(base)) * float(np.max(base.wheel_radii)) / len(base.driven)
    motor = sized_motor(wheel_speed, torque, base.mass * radius**2 / len(base.driven), SUPPLY)
    sheet = DcMotor(
        motor.resistance, motor.inductance, motor.torque_constant, motor.torque_constant, motor.rotor_inertia,
        motor.max_voltage, motor.max_current,
    )  # fmt: skip
    wheel_mass = min(WHEEL_DENSITY * np.pi * radius**3, WHEELS * base.mass / len(base.wheels))
    inertia = 0.5 * wheel_mass * radius**2
    return BaseDrive(
        sheet, Gear(motor.gear_ratio), Encoder(motor.encoder_counts), wheel_inertia=float(inertia),
        steering=usual_steering(base, speed),
    )  # fmt: skip


def usual_steering(base: WheelBase, speed: float) -> SteeringMotor:
    """Return a usual steering motor; for driven castors one that swings them as pivots move across, m/s."""
    usual = SteeringMotor()
    levers = [abs(wheel.castor_offset) for wheel in base.wheels if wheel.powered_castor]
    return replace(usual, max_rate=max(usual.max_rate, SWINGING * speed / min(levers))) if levers else usual


def _dragging(base: WheelBase) -> float:
    """Sum of rim forces, over the mass, that turns a base on the spot whose wheels all slide across, m/s^2."""
    places = np.array([(wheel.x, wheel.y) for wheel in base.wheels if wheel.kind == "skid"])
    if not len(places):
        return 0.0
    along, aside = np.abs(places - places.mean(axis=0)).mean(axis=0)
    return float(GRIP * GRAVITY * along / aside)


def _gearing(base: WheelBase) -> float:
    """Rim speed of the fastest wheel over that of the base, at least 1."""
    if base.steered:
        return 1.0
    rows = base.velocity_coupling
    return max(1.0, float(np.max(np.hypot(rows[:, 0], rows[:, 1]))), float(np.max(np.abs(rows[:, 2]))))
