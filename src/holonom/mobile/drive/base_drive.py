"""`BaseDrive`: the data sheets of what drives a base's wheels, for its controller and for its simulation alike."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from holonom.arrays import Array
from holonom.devices import Accelerometer, CurrentShunt, DcMotor, Encoder, Friction, Gear, Gyro
from holonom.errors import ModelError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.model.gravity import GRAVITY

__all__ = ["GRAVITY", "BaseDrive", "BaseSensors", "base_mass", "load_shares"]


@dataclass(frozen=True, slots=True)
class BaseDrive:
    """What drives each wheel of a base; all wheels alike.

    Attributes
    ----------
    motor, gear, encoder, friction
        Data sheets of chapter 03; encoder and friction at the motor's shaft. The gear's ratio is motor turns per wheel
        turn.
    wheel_inertia
        Wheel about its axle, without the rotor, kg m^2.
    roller_drag
        Bearing drag of the rollers of a Swedish wheel over its load.

    Raises
    ------
    ModelError
        An inertia that is not positive, a drag outside [0, 1).
    """

    motor: DcMotor
    gear: Gear
    encoder: Encoder
    friction: Friction = field(default_factory=Friction)
    wheel_inertia: float = 2.5e-5
    roller_drag: float = 0.02

    def __post_init__(self) -> None:
        if not 0.0 < self.wheel_inertia < math.inf:
            raise ModelError(f"BaseDrive: wheel_inertia is {self.wheel_inertia!r} kg m2; it must be greater than 0")
        if not 0.0 <= self.roller_drag < 1.0:
            raise ModelError(f"BaseDrive: roller_drag is {self.roller_drag!r}; it must be at least 0 and below 1")

    @property
    def inertia(self) -> float:
        """Wheel and geared rotor about the wheel's axle, kg m^2."""
        return self.wheel_inertia + self.gear.ratio**2 * self.motor.rotor_inertia


@dataclass(frozen=True, slots=True)
class BaseSensors:
    """Noise of a base's sensors; encoders quantise by themselves.

    Attributes
    ----------
    gyro_noise, gyro_bias
        Standard deviation of a 1 kHz sample, constant offset, rad/s.
    accelerometer_noise, accelerometer_bias
        The same, m/s^2, on both axes.
    current_noise
        Standard deviation of a shunt's sample, A.
    """

    gyro_noise: float = Gyro().noise
    gyro_bias: float = Gyro().bias
    accelerometer_noise: float = Accelerometer().noise
    accelerometer_bias: float = Accelerometer().bias
    current_noise: float = CurrentShunt().noise


def base_mass(base: WheelBase) -> float:
    """Mass of a base, kg.

    Raises
    ------
    ModelError
        None is stated, or the centre of mass is not above the origin of base_link.
    """
    if base.mass is None:
        raise ModelError(f"base {base.name!r} has no mass, so it cannot be driven by forces; state mass= in kg")
    if np.abs(base.com).max() > 1e-9:
        raise ModelError(
            f"base {base.name!r} has its centre of mass at {base.com.tolist()} m; controller and simulation need it "
            "above the origin of base_link: describe the wheels from there"
        )
    return base.mass


def load_shares(base: WheelBase) -> Array:
    """How weight and its two moments spread over the wheels (k, 3): the least-squares loads, driven wheels first."""
    wheels = [*(w for w in base.wheels if w.driven), *(w for w in base.wheels if not w.driven)]
    A = np.array([[1.0, w.x, w.y] for w in wheels]).T
    return np.ascontiguousarray(np.linalg.pinv(A))
