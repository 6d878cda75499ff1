"""Gear between a motor and its joint: ratio and efficiency (spec 03.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.transmission.kernels import GearParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Gear"]


@dataclass(frozen=True, slots=True)
class Gear:
    """A stiff gear without play.

    The ratio is negative where the joint turns against the motor (Puma 560, joints 1 and 3). With the efficiency
    `tau = nu eta m` while the motor drives, `nu m / eta` while the load drives it back, and anything between at
    standstill: what is lost is friction in proportion to the torque carried (`load_friction`).

    Raises
    ------
    ModelError
        A ratio of 0 or an efficiency outside (0, 1].
    """

    ratio: float = parameter(meaning="nu, motor turns per joint turn, not 0", example=62.6)
    efficiency: float = parameter(1.0, meaning="eta", above=0.0, most=1.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.ratio == 0.0:
            raise ModelError("Gear: ratio is 0; it must be the motor turns per joint turn, e.g. 62.6 or -62.6")

    @classmethod
    def rubbing(cls, ratio: float, load_friction: float) -> Gear:
        """Return the gear whose friction is the part `load_friction`, in [0, 1), of the torque that it carries.

        Raises
        ------
        ModelError
            A part outside [0, 1): at 1 no load drives it back.
        """
        require("Gear.rubbing", "load_friction", load_friction, least=0.0)
        if load_friction >= 1.0:
            raise ModelError(f"Gear.rubbing: load_friction is {load_friction:g}; it must be less than 1")
        return cls(ratio, math.sqrt((1.0 - load_friction) / (1.0 + load_friction)))

    @property
    def load_friction(self) -> float:
        """Friction over the torque carried, `(1 - eta^2) / (1 + eta^2)`."""
        return (1.0 - self.efficiency**2) / (1.0 + self.efficiency**2)

    def params(self) -> GearParams:
        """Params of `gear_torque`."""
        return GearParams(self.ratio, self.efficiency)
