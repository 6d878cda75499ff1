"""What the motors and the floor give each driven wheel: force by speed-torque line, grip by wheel load."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, is_number, real_array, shown
from holonom.devices import DcMotor, Gear
from holonom.errors import InputError, OutOfLimits, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.stability import wheel_loads

__all__ = ["DriveLimits", "drive_limits"]


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """Equal motors, gears and wheels under one body; `drive_limits` makes it from a base.

    Attributes
    ----------
    motor, gear
        Of each wheel (chapter 03).
    wheel_radius
        r in m.
    mass
        M in kg.
    friction
        mu between wheel and floor; infinite: it never slips.
    loads
        (n,) N_i in N of the driven wheels at rest.
    transfer
        (n, 2) N per m/s2: how the loads move with the acceleration (ax, ay); None where the centre of mass lies low.

    Raises
    ------
    OutOfLimits, ShapeError
    """

    motor: DcMotor
    gear: Gear
    wheel_radius: float
    mass: float
    friction: float
    loads: Array
    transfer: Array | None = None

    def __post_init__(self) -> None:
        for name in ("wheel_radius", "mass", "friction"):
            value = getattr(self, name)
            if not (is_number(value) and value > 0.0 and (name == "friction" or math.isfinite(value))):
                raise OutOfLimits(f"drive limits: {name} is {shown(value)}; it must be a number above 0")
        loads = real_array("drive limits: loads", self.loads)
        if loads.ndim != 1 or not (loads >= 0.0).all():
            raise ShapeError(f"drive limits: loads are {loads}; they must be (n,) forces in N, none below 0")
        if self.transfer is not None and np.shape(self.transfer) != (len(loads), 2):
            raise ShapeError(
                f"drive limits: transfer has shape {np.shape(self.transfer)}; it must be ({len(loads)}, 2)"
            )

    @property
    def rim_speed(self) -> float:
        """Rim speed of a free wheel at full supply, m/s."""
        return self.motor.no_load_speed * self.wheel_radius / abs(self.gear.ratio)

    def motor_limits(self, rims: ArrayLike) -> tuple[Array, Array]:
        """Least and greatest force (..., n), N, that motors can have at rim speeds (..., n), m/s.

        Current within the power stage and within what the supply drives against the back-emf; the motor's own friction
        helps to brake and hinders to drive (both hinder at rest), so does the gear's loss.
        """
        m = finite("rims", rims)
        return -self._greatest(-m), self._greatest(m)

    def _greatest(self, m: Array) -> Array:
        motor, ratio, eta = self.motor, abs(self.gear.ratio), self.gear.efficiency
        emf = motor.back_emf_constant * ratio * m / self.wheel_radius
        supplied = (motor.max_voltage - emf) / motor.resistance
        current = np.clip(supplied, -motor.max_current, motor.max_current)
        driving = m >= 0.0
        torque = motor.torque_constant * (current - np.where(driving, 1.0, -1.0) * motor.no_load_current)
        gain = np.where(driving == (torque >= 0.0), eta, 1.0 / eta)
        force: Array = ratio * gain * torque / self.wheel_radius
        return force

    def grip(self, acceleration: ArrayLike | None = None) -> Array:
        """Greatest force (..., n), N, that the floor takes from each wheel: `mu N_i`; 0 from one that lifts.

        `acceleration` (..., 2): ax, ay in m/s2, which moves load backwards; none unless given.
        """
        N = np.asarray(self.loads, float)
        if acceleration is not None and self.transfer is not None:
            N = N + np.asarray(acceleration, float) @ np.asarray(self.transfer, float).T
        if math.isinf(self.friction):
            return np.full(N.shape, np.inf)
        grip: Array = self.friction * np.maximum(N, 0.0)
        return grip


def drive_limits(base: WheelBase, motor: DcMotor, gear: Gear, friction: float) -> DriveLimits:
    """Limits of a base with equal driven wheels: loads from its mass, centre of mass and wheels (`wheel_loads`).

    Raises
    ------
    InputError
        A base without a mass, or with driven wheels of several radii.
    OutOfLimits
        A centre of mass outside the wheels.
    """
    if base.mass is None:
        raise InputError(f"base {base.name!r} states no mass; give mass= in kg when it is made")
    radii = np.unique(base.wheel_radii)
    if len(radii) > 1:
        raise InputError(f"base {base.name!r} drives wheels of radii {radii} m; make DriveLimits for equal wheels")
    loads = wheel_loads(base)
    transfer = (wheel_loads(base, np.eye(2)) - loads).T
    if (loads < -1e-9 * loads.sum()).any():
        name = base.wheels[int(loads.argmin())].name
        raise OutOfLimits(f"base {base.name!r} tips over: wheel {name!r} carries no load; move com between the wheels")
    loads = np.maximum(
        loads, 0.0
    )  # a wheel just off the line of the centre of mass carries nothing, give or take an ulp
    driven = [i for i, w in enumerate(base.wheels) if w.driven]
    return DriveLimits(
        motor, gear, float(radii[0]), base.mass, friction, loads[driven], transfer[driven] if base.com_height else None
    )
