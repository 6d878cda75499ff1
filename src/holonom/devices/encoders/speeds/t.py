"""T method: the time between two edges, `w = k q f_s / N` (N ticks for k counts; the erratum of specification 03)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from holonom.devices.encoders.speeds.readings import EdgeReading
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["TMethod", "TParams", "TState", "period_speed", "t_step"]


class TParams(NamedTuple):
    """`k q f_s`, rad/s times ticks; ticks without an edge after which the shaft stands."""

    unit: float
    longest: int


class TState(NamedTuple):
    """Speed, rad/s."""

    speed: float


@loop
def period_speed(params: TParams, speed: float, reading: EdgeReading) -> float:
    """What a speed (rad/s) can still be: with no edge for `n` ticks at most `k q f_s / n`, and 0 in the end.

    The edge came up to a tick after its stamp.
    """
    waited = reading.now - reading.stamp - 1
    if waited > params.longest:
        return 0.0
    if abs(speed) * waited > params.unit:
        return math.copysign(params.unit / waited, speed)
    return speed


@loop
def t_step(params: TParams, state: TState, reading: EdgeReading) -> TState:
    """One sample: speed 0 until two edges came in the same direction."""
    if reading.period <= 0:
        return TState(0.0)
    return TState(period_speed(params, reading.direction * params.unit / reading.period, reading))


@dataclass(frozen=True, slots=True)
class TMethod:
    """The time between two edges.

    Raises
    ------
    ModelError
        A field outside its range.
    """

    counts_per_rev: int = parameter(meaning="counts per turn after decoding", least=1, example=4000)
    timer: float = parameter(1e7, meaning="frequency of the timer", unit="Hz", above=0.0)
    edges: int = parameter(1, meaning="counts per captured edge, k", least=1)
    longest: float = parameter(0.1, meaning="time without an edge after which the shaft stands", unit="s", above=0.0)
    step: ClassVar[Callable[..., Any]] = staticmethod(t_step)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def edge_angle(self) -> float:
        """Angle between two captured edges, `k q`, rad."""
        return 2.0 * math.pi * self.edges / self.counts_per_rev

    def params(self) -> TParams:
        """Params of `t_step`."""
        return TParams(self.edge_angle * self.timer, math.ceil(self.longest * self.timer))

    def start(self, reading: EdgeReading) -> TState:
        """State at a first reading, at rest."""
        del reading
        return TState(0.0)

    def ticks(self, speed: float) -> float:
        """Ticks of the timer between two edges, `k q f_s / w`, at a speed (rad/s); infinite at rest."""
        return math.inf if speed == 0.0 else self.edge_angle * self.timer / abs(speed)

    def resolution(self, speed: float) -> float:
        """What one tick changes (rad/s), `w^2 / (k q f_s)`, at a speed (rad/s)."""
        return speed * speed / (self.edge_angle * self.timer)

    def delay(self, speed: float) -> float:
        """Mean age (s) of the value, `k q / w`, at a speed (rad/s); infinite at rest.

        Half of it is the mean over the period, half the wait for the next edge.
        """
        return math.inf if speed == 0.0 else self.edge_angle / abs(speed)
