"""The motor that turns a steered wheel about its vertical axis, with its own position loop and encoder."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.registry import check_fields, parameter

__all__ = ["SteeringMotor", "SteeringParams"]

FREQUENCY = 40.0  # Hz, of a steered wheel on its shaft
DAMPING = 0.7


class SteeringParams(NamedTuple):
    """Params of a steering motor's compiled step; angles at the wheel."""

    max_rate: float  # rad/s
    lag: float  # s
    stiffness: float  # N m/rad of its shaft
    damping: float  # N m s/rad
    max_torque: float  # N m
    half_backlash: float  # rad
    limit: float  # rad to either side of rest at which it stops
    step: float  # rad, of its encoder
    inertia: float  # kg m2, wheel and motor about the vertical axis


@dataclass(frozen=True, slots=True)
class SteeringMotor:
    """A steering motor with its gear: it follows an angle with a lag, no faster and no harder than it can.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    max_rate: float = parameter(6.0, meaning="greatest turning speed of the wheel", unit="rad/s", above=0.0)
    max_torque: float = parameter(20.0, meaning="greatest torque on the wheel", unit="N m", above=0.0)
    lag: float = parameter(0.02, meaning="time constant with which it follows an angle", unit="s", above=0.0)
    backlash: float = parameter(0.0, meaning="play between motor and wheel", unit="rad", least=0.0)
    inertia: float = parameter(2e-3, meaning="of wheel and motor about the vertical axis", unit="kg m2", above=0.0)
    counts_per_turn: int = parameter(8192, meaning="of its encoder, per turn of the wheel", least=4)

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, limit: float = math.inf) -> SteeringParams:
        """Params of its step, for a wheel that turns by up to `limit`, rad, to either side of its rest."""
        w = 2.0 * math.pi * FREQUENCY
        return SteeringParams(
            self.max_rate, self.lag, self.inertia * w * w, 2.0 * DAMPING * w * self.inertia, self.max_torque,
            0.5 * self.backlash, limit, 2.0 * math.pi / self.counts_per_turn, self.inertia,
        )  # fmt: skip
