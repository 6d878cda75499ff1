"""Supply with sag: source, its resistance, the link's capacitor, and what becomes of braking energy (spec 03.1).

`C dU/dt = (U_0 - U)/R - i`. A battery takes current back; a rectifier does not, so that a braking drive pumps the
capacitor up until a chopper burns the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["Supply", "SupplyParams", "supply_step"]


class SupplyParams(NamedTuple):
    """U_0 in V, R in ohm, C in F, whether it takes current back (1) or not (0), chopper voltage in V."""

    open_voltage: float
    resistance: float
    capacity: float
    takes_back: float
    chopper: float


@loop
def supply_step(params: SupplyParams, voltage: float, current: float, dt: float) -> float:
    """Voltage of the link (V) `dt` s later; exact while the drives draw `current` (A, negative: they brake)."""
    left = dt
    after = voltage
    if params.takes_back == 0.0 and after >= params.open_voltage:
        # the diodes block: the capacitor alone, until it is down at the source's voltage
        down = params.capacity * (after - params.open_voltage)
        if current * left <= down:
            return min(max(after - current * left / params.capacity, 0.0), max(params.chopper, voltage))
        left -= down / current
        after = params.open_voltage
    settled = params.open_voltage - params.resistance * current
    after = settled + math.exp(-left / (params.resistance * params.capacity)) * (after - settled)
    if params.takes_back == 0.0 and after > params.open_voltage:
        # it is charged beyond the source within the step: from there on the capacitor alone
        time = params.resistance * params.capacity * math.log((settled - voltage) / (settled - params.open_voltage))
        after = params.open_voltage - current * (dt - time) / params.capacity
    return min(max(after, 0.0), max(params.chopper, voltage))


@dataclass(frozen=True, slots=True)
class Supply:
    """A battery or a rectifier.

    Raises
    ------
    ModelError
        A field outside its range; a chopper below the source's voltage.
    """

    voltage: float = parameter(meaning="without load", unit="V", above=0.0, example=48.0)
    resistance: float = parameter(meaning="of source and wires", unit="ohm", above=0.0, example=0.1)
    capacity: float = parameter(meaning="of the DC link", unit="F", above=0.0, example=4.7e-3)
    regenerates: bool = parameter(True, meaning="whether the source takes current back")
    chopper_voltage: float = parameter(
        math.inf, meaning="above which braking energy is burnt", unit="V", above=0.0, most=math.inf
    )

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.chopper_voltage <= self.voltage:
            raise ModelError(
                f"Supply: chopper_voltage is {self.chopper_voltage:g} V; it must be above the source's "
                f"{self.voltage:g} V, which it would burn"
            )

    def params(self) -> SupplyParams:
        """Params of `supply_step`."""
        return SupplyParams(
            self.voltage, self.resistance, self.capacity, 1.0 if self.regenerates else 0.0, self.chopper_voltage
        )

    def sagged(self, power: float) -> float:
        """Voltage, V, at which drives draw a constant power (W): `U^2 - U_0 U + R P = 0`, the upper root.

        Raises
        ------
        ModelError
            More than `U_0^2 / (4 R)`: the voltage collapses.
        """
        require("Supply.sagged", "power", power)
        most = self.voltage**2 / (4.0 * self.resistance)
        if power > most:
            raise ModelError(f"Supply: {power:g} W are asked for; at most {most:.4g} W pass {self.resistance:g} ohm")
        return 0.5 * (self.voltage + math.sqrt(self.voltage**2 - 4.0 * self.resistance * power))
