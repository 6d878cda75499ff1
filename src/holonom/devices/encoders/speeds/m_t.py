"""M/T method: whole edges within an interval over the time between them, `w = m q f_s / N`.

T. Ohmae, T. Matsuda, K. Kamiyama, M. Tachikawa, IEEE Trans. Industrial Electronics 29(3), 1982, 207.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from holonom.devices.encoders.speeds.readings import EdgeReading
from holonom.devices.encoders.speeds.t import TParams, period_speed
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["MTMethod", "MTState", "m_t_step"]


class MTState(NamedTuple):
    """Speed, rad/s; place and ticks of the last edge of the interval before, and its direction."""

    speed: float
    edge: int
    stamp: int
    direction: int


@loop
def m_t_step(params: TParams, state: MTState, reading: EdgeReading) -> MTState:
    """One sample, once an interval."""
    speed = state.speed
    if reading.stamp > state.stamp or reading.edge != state.edge:
        if state.direction != 0 and reading.stamp > state.stamp:
            speed = (reading.edge - state.edge) * params.unit / (reading.stamp - state.stamp)
        elif reading.period > 0:
            speed = reading.direction * params.unit / reading.period
    return MTState(period_speed(params, speed, reading), reading.edge, reading.stamp, reading.direction)


@dataclass(frozen=True, slots=True)
class MTMethod:
    """Whole edges within an interval over the time between them.

    Raises
    ------
    ModelError
        A field outside its range.
    """

    counts_per_rev: int = parameter(meaning="counts per turn after decoding", least=1, example=4000)
    interval: float = parameter(5e-4, meaning="between two samples", unit="s", above=0.0)
    timer: float = parameter(1e7, meaning="frequency of the timer", unit="Hz", above=0.0)
    longest: float = parameter(0.1, meaning="time without an edge after which the shaft stands", unit="s", above=0.0)
    step: ClassVar[Callable[..., Any]] = staticmethod(m_t_step)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def edge_angle(self) -> float:
        """Angle of one count, q, rad."""
        return 2.0 * math.pi / self.counts_per_rev

    def params(self) -> TParams:
        """Params of `m_t_step`."""
        return TParams(self.edge_angle * self.timer, math.ceil(self.longest * self.timer))

    def start(self, reading: EdgeReading) -> MTState:
        """State at a first reading, at rest."""
        return MTState(0.0, reading.edge, reading.stamp, reading.direction)

    def window(self, speed: float) -> float:
        """Mean time (s) between the edges of a value, at a speed (rad/s): the interval, or a period that is longer."""
        return max(self.interval, math.inf if speed == 0.0 else self.edge_angle / abs(speed))

    def resolution(self, speed: float) -> float:
        """What one tick changes (rad/s), `w / (f_s T)` at a speed (rad/s).

        T is the shortest time between the edges of a value: the whole periods in an interval, at least one.
        """
        period = self.edge_angle / max(abs(speed), 1e-300)
        return abs(speed) / (self.timer * period * max(math.floor(self.interval / period), 1))

    def delay(self, speed: float) -> float:
        """Mean age (s) of the value, `T/2 + q/(2 w)` with the window T, at a speed (rad/s); infinite at rest."""
        wait = math.inf if speed == 0.0 else self.edge_angle / abs(speed)
        return 0.5 * self.window(speed) + 0.5 * wait
