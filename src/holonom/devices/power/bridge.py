"""PWM bridge: what reaches the motor of the voltage asked for, ripple, dead time (spec 03.1).

Mohan, Undeland, Robbins, Power Electronics, 3rd ed. 2003, ch. 7 and 8. Switched between 0 and U (one leg clocked) at
frequency f the current ripples by `U D (1 - D)/(L f)`, at most `U/(4 L f)`; between -U and U by twice that; with both
legs clocked in turn by half.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["BridgeParams", "PwmBridge", "bridge_voltage"]

PULSES = {"unipolar": 1.0, "bipolar": 2.0, "interleaved": 0.5}
"""Ripple of each way to switch, over that of one clocked leg."""


class BridgeParams(NamedTuple):
    """Voltage that dead time and switches cost (V), part of the supply that can be reached, resistance in ohm."""

    lost: float
    reach: float
    resistance: float


@loop
def bridge_voltage(params: BridgeParams, asked: float, current: float, supply: float) -> float:
    """Mean voltage over a period, V, at the motor; `supply` in V, `current` (A) decides which way dead time goes.

    While both switches are open the current keeps flowing through a diode, against the voltage that drives it.
    """
    most = params.reach * supply
    given = min(max(asked, -most), most)
    lost = params.lost if current > 0.0 else (-params.lost if current < 0.0 else 0.0)
    return given - lost - params.resistance * current


@dataclass(frozen=True, slots=True)
class PwmBridge:
    """Data of a bridge of switches.

    Raises
    ------
    ModelError
        A field outside its range; dead time of half a period and more.
    """

    voltage: float = parameter(meaning="of the DC link", unit="V", above=0.0, example=48.0)
    frequency: float = parameter(meaning="of the clock", unit="Hz", above=0.0, example=20e3)
    dead_time: float = parameter(0.0, meaning="both switches of a leg are open", unit="s", least=0.0)
    resistance: float = parameter(0.0, meaning="of the switches in the path", unit="ohm", least=0.0)
    switching: str = parameter("unipolar", meaning="which legs are clocked", choices=tuple(PULSES))

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        require("PwmBridge", "dead_time", self.dead_time, most=0.499 / self.frequency)

    @property
    def dead_time_voltage(self) -> float:
        """Mean voltage, V, that dead time takes against the current: `U t_d f`."""
        return self.voltage * self.dead_time * self.frequency

    def ripple(self, inductance: float, duty: float | None = None) -> float:
        """Peak to peak current ripple, A; the largest unless a duty is given.

        Parameters
        ----------
        inductance : of the motor, H; its resistance left out, which makes the ripple an upper bound.
        duty : 0 to 1; mean voltage over the supply's, of a bipolar bridge the part of the period at +U.
        """
        require("PwmBridge.ripple", "inductance", inductance, above=0.0)
        part = 0.5 if duty is None else duty
        require("PwmBridge.ripple", "duty", part, least=0.0, most=1.0)
        return PULSES[self.switching] * self.voltage * part * (1.0 - part) / (inductance * self.frequency)

    def params(self) -> BridgeParams:
        """Params of `bridge_voltage`."""
        return BridgeParams(self.dead_time_voltage, 1.0 - 2.0 * self.dead_time * self.frequency, self.resistance)
