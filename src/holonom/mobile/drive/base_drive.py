"""`BaseDrive`: the data sheets of what drives a base's wheels, for its controller and for its simulation alike."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from holonom.arrays import Array
from holonom.devices import Accelerometer, CurrentShunt, DcMotor, Encoder, Friction, Gear, Gyro, SteeringMotor
from holonom.errors import ModelError
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.model.gravity import GRAVITY
from holonom.numeric.contact_loads import pushing_loads

__all__ = ["GRAVITY", "BaseDrive", "BaseSensors", "base_mass", "load_shares", "rest_loads", "roller_cosines",
           "standing_wheels", "stands_in_line", "supports"]  # fmt: skip


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
    steering
        Motors of the steered wheels.

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
    steering: SteeringMotor = field(default_factory=SteeringMotor)

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
        None is stated.
    """
    if base.mass is None:
        raise ModelError(f"base {base.name!r} has no mass, so it cannot be driven by forces; state mass= in kg")
    return base.mass


def supports(base: WheelBase) -> Array:
    """Where `standing_wheels` stand about the centre of mass (k, 2), m; castors at their pivots."""
    return np.array([(w.x, w.y) for w in standing_wheels(base)]) - base.com


def standing_wheels(base: WheelBase) -> list[Wheel]:
    """Return the wheels of a base: driven ones, then free ones, then passive balls."""
    return sorted(base.wheels, key=lambda wheel: (not wheel.driven, wheel.kind == "spherical"))


def load_shares(base: WheelBase) -> Array:
    """How weight and its moments about the centre of mass spread over the wheels (k, 3), driven ones first.

    The loads of least square sum while all wheels stay down; of rockers and bogies those that balance on their pivots.
    Wheels on one line carry moments along it; what holds the base upright carries those across.
    """
    if base.suspension == "rocker_bogie":
        return rocker_shares(base)
    at = supports(base)
    if _in_line(at):
        apart = at - at.mean(axis=0)
        at = at @ np.linalg.pinv(apart) @ apart
    A = np.concatenate([np.ones((1, len(at))), at.T])
    return np.ascontiguousarray(np.linalg.pinv(A))


def rocker_shares(base: WheelBase) -> Array:
    """Shares (6, 3) of weight and its moments where a bogie on each side carries its two rear wheels alike.

    The rockers turn about the body amid the wheels, and a differential makes their moments there equal.

    Raises
    ------
    ModelError
        Not six wheels, three on each side.
    """
    at = supports(base)
    beside = at[:, 1] - at[:, 1].mean()
    sides = [sorted(np.flatnonzero(sign * beside > 0.0), key=lambda k: -at[k, 0]) for sign in (1.0, -1.0)]
    if [len(side) for side in sides] != [3, 3]:
        raise ModelError(f"base {base.name!r} has {len(at)} wheels; rockers and bogies carry three on each side")
    rows, asked = [np.ones(6), at[:, 0], at[:, 1]], [*np.eye(3)]
    pivot, moments = at[:, 0].mean(), np.zeros(6)
    for (_, middle, rear), sign in zip(sides, (1.0, -1.0), strict=True):
        equal = np.zeros(6)
        equal[middle], equal[rear] = 1.0, -1.0
        rows.append(equal)
        moments += sign * np.isin(np.arange(6), sides[0 if sign > 0.0 else 1]) * (at[:, 0] - pivot)
    rows.append(moments)
    asked += [np.zeros(3)] * 3
    return np.ascontiguousarray(np.linalg.solve(np.array(rows), np.array(asked)))


def _in_line(at: Array) -> bool:
    """Whether places (k, 2) span no area."""
    return bool(np.linalg.matrix_rank(at - at.mean(axis=0), tol=1e-9) < 2)


def stands_in_line(base: WheelBase) -> bool:
    """Whether a base whose wheels span no area carries its weight on their line, held upright across it.

    On one wheel alone its centre of mass lies above that: beside it weight would tip it, and push turn it.
    """
    at = supports(base)
    if np.ptp(at, axis=0).max() < 1e-9:
        return bool(np.abs(at).max() < 1e-6)
    return bool(load_shares(base)[:, 0].min() > -1e-9)


def roller_cosines(base: WheelBase) -> Array:
    """Cosines (m,) of the angles at which the driven wheels push: of the rollers of Swedish ones, else 1."""
    return np.cos([w.roller_angle for w in base.wheels if w.driven])


def rest_loads(base: WheelBase) -> Array:
    """Loads (m,), N, of the driven wheels at rest: they only push; one on a line of wheels is held upright across it.

    Raises
    ------
    ModelError
        It states no mass, or tips at rest.
    """
    mass, at = base_mass(base), supports(base)
    if _in_line(at):
        loads, stands = load_shares(base)[:, 0], stands_in_line(base)
    else:
        loads, carried = pushing_loads(at, np.zeros(2))
        stands = bool(carried)
    count = sum(w.driven for w in base.wheels)
    if not stands:
        raise ModelError(
            f"base {base.name!r} tips at rest: its centre of mass {base.com.tolist()} m lies outside its wheels; move "
            "it between them"
        )
    return np.asarray(mass * GRAVITY * loads[:count])
