"""Current of a motor: a shunt, and a shunt with its amplifier and converter (spec 03.4)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["CurrentParams", "CurrentSensor", "CurrentShunt", "current_reading"]

FINEST = 2.0**-31  # of the range


@dataclass(frozen=True, slots=True)
class CurrentShunt:
    """A shunt in series with an armature; raises as `Gyro` does."""

    noise: float = parameter(0.03, meaning="standard deviation of a sample", unit="A", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


class CurrentParams(NamedTuple):
    """Gain (1 where there is no error), offset, noise, largest reading and resolution in A; what a step forgets."""

    gain: float
    offset: float
    noise: float
    most: float
    resolution: float
    decay: float


@loop
def current_reading(params: CurrentParams, filtered: float, current: float, white: float) -> tuple[float, float]:
    """Reading (A) and the filter's state after a step in which the current stood still, exact.

    `white` is normal with variance 1, drawn by the caller. Beyond its range the reading stays at the end.
    """
    p = params
    filtered = current + p.decay * (filtered - current)
    found = p.gain * filtered + p.offset + p.noise * white
    if p.resolution > 0.0:
        found = p.resolution * math.floor(found / p.resolution + 0.5)
    return min(max(found, -p.most), p.most), filtered


@dataclass(frozen=True, slots=True)
class CurrentSensor:
    """A shunt with its amplifier, filter and converter.

    Raises
    ------
    ModelError
        A number outside its range, a resolution coarser than the range, or too fine.
    """

    most: float = parameter(meaning="largest current that it reads", unit="A", above=0.0, example=20.0)
    noise: float = parameter(0.0, meaning="standard deviation of a sample", unit="A", least=0.0)
    offset: float = parameter(0.0, meaning="reading without current", unit="A")
    gain_error: float = parameter(0.0, meaning="part by which it reads too much", above=-1.0)
    resolution: float = parameter(0.0, meaning="of the converter, 0 where it has none", unit="A", least=0.0)
    lag: float = parameter(0.0, meaning="time constant of its filter", unit="s", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        require("CurrentSensor", "resolution", self.resolution, most=self.most)
        if 0.0 < self.resolution < self.most * FINEST:
            raise ModelError(
                f"CurrentSensor: resolution is {self.resolution:g}; over {self.most:g} A no converter has "
                "more than 32 bits: give 0 where there is none"
            )

    def params(self, dt: float) -> CurrentParams:
        """Params of `current_reading` for a step of `dt` (s)."""
        require("CurrentSensor.params", "dt", dt, above=0.0)
        decay = math.exp(-dt / self.lag) if self.lag > 0.0 else 0.0
        return CurrentParams(1.0 + self.gain_error, self.offset, self.noise, self.most, self.resolution, decay)

    def error(self, current: float) -> float:
        """Largest error (A) of a settled reading of a current (A), three deviations of noise included.

        Raises
        ------
        ModelError
            A current that it cannot read.
        """
        size = abs(current)
        wrong = abs(self.gain_error) * size + abs(self.offset) + 0.5 * self.resolution + 3.0 * self.noise
        require("CurrentSensor.error", "current", size, most=self.most - wrong)
        return wrong
