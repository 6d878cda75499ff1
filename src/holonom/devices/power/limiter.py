"""Current limiter: a dead band in negative feedback, as analogue drives have it (000 3.6.1; spec 03.1).

The voltage asked for passes as it is while the current stays within the band; beyond, what exceeds it is fed back with
a high gain: `u = u_r - k (i - I sign i)`. At standstill the current ends at `I + (u_r - R I)/(R + k)`, a little above
the limit, and the stiffer the gain the less; clipping the reference of a current loop has no such remainder.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["CurrentLimiter", "LimiterParams", "limiter_voltage"]


class LimiterParams(NamedTuple):
    """Band in A, gain in V/A."""

    band: float
    gain: float


@loop
def limiter_voltage(params: LimiterParams, asked: float, current: float) -> float:
    """Voltage (V) that is left of the one asked for, at a measured current (A)."""
    if current > params.band:
        return asked - params.gain * (current - params.band)
    if current < -params.band:
        return asked - params.gain * (current + params.band)
    return asked


@dataclass(frozen=True, slots=True)
class CurrentLimiter:
    """Band and gain of the limiter.

    Raises
    ------
    ModelError
    """

    band: float = parameter(meaning="current that is left alone", unit="A", above=0.0, example=10.0)
    gain: float = parameter(meaning="voltage taken away per current beyond", unit="V/A", above=0.0, example=20.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self) -> LimiterParams:
        """Params of `limiter_voltage`."""
        return LimiterParams(self.band, self.gain)

    def stall_current(self, voltage: float, resistance: float) -> float:
        """Settled current, A, of a motor at standstill: `(u + k I)/(R + k)` beyond the band."""
        require("CurrentLimiter.stall_current", "resistance", resistance, above=0.0)
        require("CurrentLimiter.stall_current", "voltage", voltage)
        free = voltage / resistance
        if abs(free) <= self.band:
            return free
        current = (abs(voltage) + self.gain * self.band) / (resistance + self.gain)
        return current if voltage > 0.0 else -current

    def largest_gain(self, inductance: float, resistance: float, dt: float) -> float:
        """Gain (V/A) from which a sampled limiter no longer settles: `R (1 + d)/(1 - d)`, `d = exp(-R dt/L)`.

        `dt` is the time between samples (s); half of it is a good choice.
        """
        require("CurrentLimiter.largest_gain", "inductance", inductance, above=0.0)
        require("CurrentLimiter.largest_gain", "resistance", resistance, above=0.0)
        require("CurrentLimiter.largest_gain", "dt", dt, above=0.0)
        decay = math.exp(-resistance * dt / inductance)
        return resistance * (1.0 + decay) / (1.0 - decay)
