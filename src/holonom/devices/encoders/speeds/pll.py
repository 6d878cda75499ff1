"""Phase-locked loop: a second-order loop follows the count; its integrator is the speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from holonom.devices.encoders.speeds.readings import EdgeReading
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["PllMethod", "PllParams", "PllState", "pll_step"]


class PllParams(NamedTuple):
    """Interval, s; angle of a count, rad; corrections of angle (1) and speed (1/s) per error."""

    dt: float
    resolution: float
    angle_gain: float
    speed_gain: float


class PllState(NamedTuple):
    """Speed, rad/s; angle, rad."""

    speed: float
    angle: float


@loop
def pll_step(params: PllParams, state: PllState, reading: EdgeReading) -> PllState:
    """One sample: predict, correct by what the middle of the count differs."""
    predicted = state.angle + params.dt * state.speed
    error = (reading.counts + 0.5) * params.resolution - predicted
    return PllState(state.speed + params.speed_gain * error, predicted + params.angle_gain * error)


@dataclass(frozen=True, slots=True)
class PllMethod:
    """A loop with two poles at the bandwidth, at `r = exp(-bandwidth T_s)` when sampled.

    Raises
    ------
    ModelError
        A field outside its range.
    """

    counts_per_rev: int = parameter(meaning="counts per turn after decoding", least=1, example=4000)
    interval: float = parameter(5e-4, meaning="between two samples", unit="s", above=0.0)
    bandwidth: float = parameter(400.0, meaning="of the loop", unit="rad/s", above=0.0)
    step: ClassVar[Callable[..., Any]] = staticmethod(pll_step)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self) -> PllParams:
        """Params of `pll_step`."""
        r = self._pole
        return PllParams(
            self.interval, 2.0 * math.pi / self.counts_per_rev, 1.0 - r * r, (1.0 - r) ** 2 / self.interval
        )

    def start(self, reading: EdgeReading) -> PllState:
        """State at a first reading, at rest."""
        return PllState(0.0, (reading.counts + 0.5) * self.params().resolution)

    def resolution(self, speed: float) -> float:
        """Most (rad/s) that one count moves the speed, at any speed: about `q bandwidth / e`.

        A count changes it by `(1 - r)^2 (n + 1) r^n / T_s` after n samples.
        """
        del speed
        r, p = self._pole, self.params()
        n = math.floor(r / (1.0 - r))
        return p.resolution * p.speed_gain * (n + 1) * r**n

    def delay(self, speed: float) -> float:
        """What the speed is late (s) while it changes evenly: `T_s ((1 + r)/(1 - r) - 1/2)`, about `2 / bandwidth`."""
        del speed
        r = self._pole
        return self.interval * ((1.0 + r) / (1.0 - r) - 0.5)

    @property
    def _pole(self) -> float:
        return math.exp(-self.bandwidth * self.interval)
