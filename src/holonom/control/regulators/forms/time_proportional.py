"""Time-proportional: the output of a PI regulator, as the part of each period for which a switch is on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PiSettings, Regulator
from holonom.control.servo.kernels import PiParams, pi_start, pi_step
from holonom.errors import OutOfLimits
from holonom.registry import Method, parameter
from holonom.trace.code.loops import loop

__all__ = ["TIME_PROPORTIONAL", "TimeParams", "TimeSettings", "TimeState", "time_proportional_step"]


class TimeParams(NamedTuple):
    """The PI regulator that computes once a period, and the samples of a period."""

    pi: PiParams
    samples: int


class TimeState(NamedTuple):
    """Integral, samples of this period that are over and for which it is on, last output."""

    integral: float
    over: int
    on: int
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeSettings(PiSettings):
    """Gain, integral time and period.

    Raises
    ------
    OutOfLimits
        A number outside its range; of `params`: a period of less than two samples.
    """

    period: float = parameter(meaning="of switching: on for a part of it", unit="s", above=0.0, example=1.0)

    def params(self, dt: float) -> TimeParams:
        """Params of `time_proportional_step` at a sample time, s; the period is made of whole samples."""
        samples = round(self.period / dt)
        if samples < 2:
            raise OutOfLimits(
                f"period is {self.period!r} s at a sample time of {dt:g} s; two samples at least are needed"
            )
        return TimeParams(PiParams(self.Kc, self.Kc * samples * dt / self.Ti), samples)


@loop
def time_proportional_step(
    params: TimeParams, state: TimeState, r: float, y: float, low: float, high: float
) -> tuple[float, TimeState]:
    """Output, `high` or `low`, and next state; the mean over a period is the regulator's output, to 1/2 sample."""
    integral, on = state.integral, state.on
    if state.over == 0 and math.isfinite(r - y):
        wanted, integral = pi_step(params.pi, integral, r - y, 0.0, low, high)
        on = math.floor((wanted - low) / (high - low) * params.samples + 0.5)
    u = high if state.over < on else low
    over = state.over + 1
    return u, TimeState(integral, 0 if over == params.samples else over, on, u)


@loop
def time_proportional_start(params: TimeParams, u: float, r: float, y: float, low: float, high: float) -> TimeState:
    """State at the beginning of a period, whose mean is u at this r and y."""
    on = math.floor((u - low) / (high - low) * params.samples + 0.5)
    return TimeState(pi_start(params.pi, u, r - y, 0.0), 0, on, low)


TIME_PROPORTIONAL = Method(
    "PI as the on-time of a switch within each period; no recoil",
    lambda settings: Regulator(time_proportional_step, time_proportional_start, settings, recoils=False, switches=True),
    "Shinskey, Process Control Systems, 1967; specification 04.1",
    TimeSettings,
)
