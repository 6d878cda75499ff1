"""Gear between a motor and its joint: ratio and efficiency (spec 03.2)."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.kernels import GearParams
from holonom.errors import ModelError

__all__ = ["Gear"]


@dataclass(frozen=True, slots=True)
class Gear:
    """A stiff gear without play.

    Attributes
    ----------
    ratio
        Motor turns per joint turn; negative where the joint turns against the motor (Puma 560, joints 1 and
        3).
    efficiency
        In (0, 1]: `tau = nu eta m` while the motor drives, `nu m / eta` while the load drives it back.

    Raises
    ------
    ModelError
        A ratio of 0 or an efficiency outside (0, 1].
    """

    ratio: float
    efficiency: float = 1.0

    def __post_init__(self) -> None:
        require("Gear", "ratio", self.ratio)
        require("Gear", "efficiency", self.efficiency, above=0.0, most=1.0)
        if self.ratio == 0.0:
            raise ModelError("Gear: ratio is 0; it must be the motor turns per joint turn, e.g. 62.6 or -62.6")

    def params(self) -> GearParams:
        """Params of `gear_torque`."""
        return GearParams(self.ratio, self.efficiency)
