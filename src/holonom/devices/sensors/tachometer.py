"""Tachometer: a voltage in proportion to speed, the ripple of its commutator, a filter (spec 03.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["Tachometer", "TachometerParams", "tachometer_step"]


class TachometerParams(NamedTuple):
    """T_D in V s/rad; ripple as a part, and its periods per turn; noise in V; what a step of the filter forgets."""

    gain: float
    ripple: float
    periods: float
    noise: float
    decay: float


@loop
def tachometer_step(
    params: TachometerParams, filtered: float, angle: float, speed: float, white: float
) -> tuple[float, float]:
    """Voltage read (V) and the filter's after a step at a shaft's angle (rad) and speed (rad/s).

    `white` is normal with variance 1, drawn by the caller.
    """
    p = params
    made = p.gain * speed * (1.0 + p.ripple * math.sin(p.periods * angle))
    filtered = made + p.decay * (filtered - made)
    return filtered + p.noise * white, filtered


@dataclass(frozen=True, slots=True)
class Tachometer:
    """A DC tachometer on a shaft.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    gain: float = parameter(meaning="T_D", unit="V s/rad", above=0.0, example=0.07)
    ripple: float = parameter(0.01, meaning="amplitude over the mean", least=0.0, below=1.0)
    periods: int = parameter(22, meaning="of the ripple in a turn", least=1)
    lag: float = parameter(1e-3, meaning="time constant of the filter", unit="s", least=0.0)
    noise: float = parameter(0.0, meaning="standard deviation of a sample", unit="V", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self, dt: float) -> TachometerParams:
        """Params of `tachometer_step` for a step of `dt` (s)."""
        require("Tachometer.params", "dt", dt, above=0.0)
        decay = math.exp(-dt / self.lag) if self.lag > 0.0 else 0.0
        return TachometerParams(self.gain, self.ripple, float(self.periods), self.noise, decay)

    def ripple_at(self, speed: float) -> float:
        """Amplitude (rad/s) of the ripple that a steady speed (rad/s) has behind the filter."""
        require("Tachometer.ripple_at", "speed", speed)
        return self.ripple * abs(speed) / math.hypot(1.0, self.periods * speed * self.lag)

    @property
    def delay(self) -> float:
        """By which a ramp of speed is read late, s: the filter's time constant."""
        return self.lag
