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
from holonom.mobile.stability import Stance, contact_points, wheel_loads
from holonom.model.gravity import GRAVITY

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
    stance
        How the base stands on all its wheels, which says how loads move with the acceleration; None: they do not.
    roller_angles
        (n,) gamma_i of Swedish wheels, rad: they push along their rollers' axes only; 0 for all unless given.

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
    stance: Stance | None = None
    roller_angles: Array | None = None

    def __post_init__(self) -> None:
        for name in ("wheel_radius", "mass", "friction"):
            value = getattr(self, name)
            if not (is_number(value) and value > 0.0 and (name == "friction" or math.isfinite(value))):
                raise OutOfLimits(f"drive limits: {name} is {shown(value)}; it must be a number above 0")
        loads = real_array("drive limits: loads", self.loads)
        if loads.ndim != 1 or not (loads >= 0.0).all():
            raise ShapeError(f"drive limits: loads are {loads}; they must be (n,) forces in N, none below 0")
        angles = finite("drive limits: roller_angles", self.angles)
        if angles.shape != loads.shape:
            raise ShapeError(f"drive limits: roller_angles have shape {angles.shape}; it must be {loads.shape}")
        if self.stance is not None and len(self.stance.driven) != len(loads):
            raise ShapeError(
                f"drive limits: the stance has {len(self.stance.driven)} driven wheels; loads are {loads.shape}"
            )

    @property
    def angles(self) -> ArrayLike:
        """Roller angles of the driven wheels, rad."""
        return np.zeros(np.shape(self.loads)) if self.roller_angles is None else self.roller_angles

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
        """Greatest force (..., n), N, at the rims that the floor takes: `mu N_i cos(gamma_i)`; 0 from one that lifts.

        `acceleration` (..., 2): of the centre of mass, m/s2, which moves load backwards; none unless given. None grips
        where the base tips.
        """
        N = np.asarray(self.loads, float)
        if acceleration is not None and self.stance is not None:
            N = self.stance.loads(finite("acceleration", acceleration))[0]
        if math.isinf(self.friction):
            return np.where(N > 0.0, np.inf, 0.0) if self.stance is not None else np.full(N.shape, np.inf)
        grip: Array = self.friction * np.cos(self.angles) * N
        return grip


def drive_limits(base: WheelBase, motor: DcMotor, gear: Gear, friction: float) -> DriveLimits:
    """Limits of a base with equal driven wheels: loads from its mass, centre of mass and wheels (`wheel_loads`).

    Raises
    ------
    InputError
        A base without a mass, with driven wheels of several radii, or with a driven ball, whose drives share its grip.
    OutOfLimits
        A centre of mass outside the wheels.
    """
    if base.mass is None:
        raise InputError(f"base {base.name!r} states no mass; give mass= in kg when it is made")
    radii = np.unique(base.wheel_radii)
    if len(radii) > 1:
        raise InputError(f"base {base.name!r} drives wheels of radii {radii} m; make DriveLimits for equal wheels")
    wheels = [w for w in base.wheels if w.driven]
    ball = next((w.name for w in wheels if w.kind in ("spherical", "ball")), None)
    if ball is not None:
        raise InputError(
            f"base {base.name!r} drives the ball {ball!r} three ways at one contact; only wheels have limits"
        )
    driven = tuple(i for i, w in enumerate(base.wheels) if w.driven)
    loads = wheel_loads(base)[list(driven)]
    stance = Stance(contact_points(base) - base.com, base.mass * GRAVITY, base.com_height, driven)
    angles = np.array([w.roller_angle for w in wheels])
    return DriveLimits(motor, gear, float(radii[0]), base.mass, friction, loads, stance, angles)
