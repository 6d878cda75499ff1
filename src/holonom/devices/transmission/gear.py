"""Gear between a motor and its joint: ratio and efficiency (spec 03.2)."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices.transmission.kernels import GearParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Gear"]


@dataclass(frozen=True, slots=True)
class Gear:
    """A stiff gear without play.

    The ratio is negative where the joint turns against the motor (Puma 560, joints 1 and 3). With the efficiency
    `tau = nu eta m` while the motor drives, `nu m / eta` while the load drives it back.

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

    def params(self) -> GearParams:
        """Params of `gear_torque`."""
        return GearParams(self.ratio, self.efficiency)
