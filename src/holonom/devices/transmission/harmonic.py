"""Harmonic drive: ratio by its teeth, stiffness in pieces, an error twice a turn of the wave generator (spec 03.2).

Stiffness as catalogues print it: K_1 up to the torque T_1, K_2 up to T_2, K_3 beyond. Tuttle & Seering, IEEE
Transactions on Robotics and Automation 12(3), 1996, for error and stiffness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.devices.transmission.gear import Gear
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["HarmonicDrive", "HarmonicParams", "HarmonicTorques", "harmonic_torques", "piecewise_torque"]


class HarmonicParams(NamedTuple):
    """Ratio; K_1, K_2, K_3 in N m/rad; twists at T_1, T_2 in rad; damping in N m s/rad; error in rad, and its phase."""

    ratio: float
    stiffness_1: float
    stiffness_2: float
    stiffness_3: float
    twist_1: float
    twist_2: float
    damping: float
    ripple: float
    phase: float


class HarmonicTorques(NamedTuple):
    """What the drive takes from its motor and gives to its joint, N m."""

    motor: float
    joint: float


@loop
def piecewise_torque(params: HarmonicParams, twist: float) -> float:
    """Torque (N m) of the flexspline that is twisted by an angle (rad)."""
    p, size = params, abs(twist)
    torque = p.stiffness_1 * min(size, p.twist_1)
    torque += p.stiffness_2 * max(min(size, p.twist_2) - p.twist_1, 0.0)
    torque += p.stiffness_3 * max(size - p.twist_2, 0.0)
    return math.copysign(torque, twist)


@loop
def harmonic_torques(
    params: HarmonicParams, motor_angle: float, motor_speed: float, joint_angle: float, joint_speed: float
) -> HarmonicTorques:
    """Torques at both ends, at the angles (rad) and speeds (rad/s) of wave generator and joint.

    The teeth carry the joint to `theta / nu + a sin(2 theta + phi)`; what it is short of that is twist. The motor feels
    the slope of that function times the torque, so that no energy comes from the error.
    """
    p = params
    beat = 2.0 * motor_angle + p.phase
    slope = 1.0 / p.ratio + 2.0 * p.ripple * math.cos(beat)
    twist = motor_angle / p.ratio + p.ripple * math.sin(beat) - joint_angle
    torque = piecewise_torque(p, twist) + p.damping * (slope * motor_speed - joint_speed)
    return HarmonicTorques(slope * torque, torque)


@dataclass(frozen=True, slots=True)
class HarmonicDrive:
    """A harmonic drive with a circular spline of z1 teeth and a flexspline of z2.

    `nu = z2 / (z1 - z2)`, z1 the circular spline's: positive, the sign of 000 3.4.1. With the circular spline fixed
    the flexspline turns against the wave generator; where that counts, `reverses` makes the ratio negative.

    Raises
    ------
    ModelError
        A number outside its range, no more teeth on the circular spline than on the flexspline, T_2 below T_1.
    """

    circular_teeth: int = parameter(meaning="z1, of the circular spline", least=3, example=202)
    flex_teeth: int = parameter(meaning="z2, of the flexspline", least=2, example=200)
    stiffness_1: float = parameter(meaning="K_1, at little torque", unit="N m/rad", above=0.0, example=1.3e4)
    stiffness_2: float = parameter(meaning="K_2, between both torques", unit="N m/rad", above=0.0, example=1.8e4)
    stiffness_3: float = parameter(meaning="K_3, beyond", unit="N m/rad", above=0.0, example=2.3e4)
    torque_1: float = parameter(meaning="T_1, up to which K_1 holds", unit="N m", above=0.0, example=14.0)
    torque_2: float = parameter(meaning="T_2, up to which K_2 holds", unit="N m", above=0.0, example=48.0)
    damping: float = parameter(0.0, meaning="of the flexspline", unit="N m s/rad", least=0.0)
    ripple: float = parameter(0.0, meaning="amplitude of the error at the joint", unit="rad", least=0.0)
    phase: float = parameter(0.0, meaning="of the error", unit="rad")
    reverses: bool = parameter(False, meaning="whether the joint turns against the motor")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.circular_teeth <= self.flex_teeth:
            raise ModelError(
                f"HarmonicDrive: {self.circular_teeth} circular and {self.flex_teeth} flex teeth; the circular spline "
                "has more, usually two"
            )
        require("HarmonicDrive", "torque_2", self.torque_2, least=self.torque_1)

    @property
    def ratio(self) -> float:
        """Motor turns per joint turn."""
        size = self.flex_teeth / (self.circular_teeth - self.flex_teeth)
        return -size if self.reverses else size

    @property
    def speed_ripple(self) -> float:
        """Amplitude of the ripple of the joint's speed over its mean: `2 a |nu|`."""
        return 2.0 * self.ripple * abs(self.ratio)

    def gear(self, efficiency: float = 1.0) -> Gear:
        """Return it as a stiff gear."""
        return Gear(self.ratio, efficiency)

    def twist(self, torque: float) -> float:
        """Twist (rad) under a torque (N m): what the joint is behind by."""
        require("HarmonicDrive.twist", "torque", torque)
        size = abs(torque)
        twist = min(size, self.torque_1) / self.stiffness_1
        twist += max(min(size, self.torque_2) - self.torque_1, 0.0) / self.stiffness_2
        return math.copysign(twist + max(size - self.torque_2, 0.0) / self.stiffness_3, torque)

    def params(self) -> HarmonicParams:
        """Params of `harmonic_torques`."""
        first = self.torque_1 / self.stiffness_1
        second = first + (self.torque_2 - self.torque_1) / self.stiffness_2
        return HarmonicParams(
            self.ratio,
            self.stiffness_1,
            self.stiffness_2,
            self.stiffness_3,
            first,
            second,
            self.damping,
            self.ripple,
            self.phase,
        )
