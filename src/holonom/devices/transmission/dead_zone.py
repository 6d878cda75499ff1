"""Dead zone: what moves nothing, its inverse, and what a tachometer loop leaves of it (spec 03.2, 03.5)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["DeadZone", "DeadZoneParams", "dead_zone", "undo_dead_zone"]


class DeadZoneParams(NamedTuple):
    """Largest inputs of either sign that move nothing."""

    positive: float
    negative: float


@loop
def dead_zone(params: DeadZoneParams, given: float) -> float:
    """Return what of an input is beyond the zone."""
    return max(given - params.positive, 0.0) + min(given + params.negative, 0.0)


@loop
def undo_dead_zone(params: DeadZoneParams, wanted: float) -> float:
    """Input that gives `wanted` behind the zone: the inverse, which jumps over it; 0 for 0."""
    if wanted > 0.0:
        return wanted + params.positive
    if wanted < 0.0:
        return wanted - params.negative
    return 0.0


@dataclass(frozen=True, slots=True)
class DeadZone:
    """Inputs between `-negative` and `positive` move nothing: a voltage below what friction takes, say.

    Raises
    ------
    ModelError
        A width that is negative or not finite.
    """

    positive: float = parameter(0.0, meaning="largest positive input that moves nothing, as the input", least=0.0)
    negative: float = parameter(0.0, meaning="the same to the other side, a magnitude", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self) -> DeadZoneParams:
        """Params of `dead_zone` and `undo_dead_zone`."""
        return DeadZoneParams(self.positive, self.negative)

    def behind_tachometer(self, speed_gain: float, tachometer_gain: float) -> DeadZone:
        """Return what a tachometer loop around the motor leaves of it: `dead zone / (1 + A_M T_D)`.

        Of a reference that asks for the same speeds as without the loop, so is `1 + A_M T_D` times as large inside it.

        Parameters
        ----------
        speed_gain : A_M of the motor, with its amplifier, rad/s per unit of the input.
        tachometer_gain : T_D, units of the input per rad/s.

        Raises
        ------
        ModelError
            A gain that is negative or not finite.
        """
        require("DeadZone.behind_tachometer", "speed_gain", speed_gain, least=0.0)
        require("DeadZone.behind_tachometer", "tachometer_gain", tachometer_gain, least=0.0)
        part = 1.0 / (1.0 + speed_gain * tachometer_gain)
        return DeadZone(self.positive * part, self.negative * part)
