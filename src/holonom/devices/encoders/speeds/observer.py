"""Observer: angle, speed and load from each count (`tracking_step`); a known acceleration may be fed to that one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from holonom.devices.encoders.incremental import Encoder, tracking_params
from holonom.devices.encoders.kernels import TrackingParams, TrackingState, tracking_step
from holonom.devices.encoders.speeds.readings import EdgeReading
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["ObserverMethod", "ObserverParams", "ObserverState", "observer_step"]


class ObserverParams(NamedTuple):
    """The tracking loop; angle of a count, rad."""

    tracking: TrackingParams
    resolution: float


class ObserverState(NamedTuple):
    """Speed, rad/s; state of the tracking loop."""

    speed: float
    tracking: TrackingState


@loop
def observer_step(params: ObserverParams, state: ObserverState, reading: EdgeReading) -> ObserverState:
    """One sample."""
    after = tracking_step(params.tracking, state.tracking, (reading.counts + 0.5) * params.resolution, 0.0)
    return ObserverState(after.speed, after)


@dataclass(frozen=True, slots=True)
class ObserverMethod:
    """An observer with three poles at the bandwidth.

    Raises
    ------
    ModelError
        A field outside its range.
    """

    counts_per_rev: int = parameter(meaning="counts per turn after decoding", least=1, example=4000)
    interval: float = parameter(5e-4, meaning="between two samples", unit="s", above=0.0)
    bandwidth: float = parameter(400.0, meaning="of the observer", unit="rad/s", above=0.0)
    step: ClassVar[Callable[..., Any]] = staticmethod(observer_step)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self) -> ObserverParams:
        """Params of `observer_step`."""
        return ObserverParams(tracking_params(self.bandwidth, self.interval), Encoder(self.counts_per_rev).resolution)

    def start(self, reading: EdgeReading) -> ObserverState:
        """State at a first reading, at rest."""
        return ObserverState(0.0, TrackingState((reading.counts + 0.5) * self.params().resolution, 0.0, 0.0))

    def resolution(self, speed: float) -> float:
        """Most (rad/s) that one count moves the speed, at any speed.

        `q b (3 x - x^2) e^-x` at `x = b t = (5 - sqrt(13))/2`, 0.800 q b, of a loop that is sampled fast; the response
        of a sampled one is stepped through.
        """
        del speed
        p, state, most = self.params(), TrackingState(0.0, 0.0, 0.0), 0.0
        if self.bandwidth * self.interval < SLOW:
            return 0.800 * self.bandwidth * p.resolution
        while True:
            state = TrackingState(*_tracked(p.tracking, state, p.resolution))
            if state.speed <= most:
                return most
            most = state.speed

    def delay(self, speed: float) -> float:
        """What the speed is late (s) while it changes evenly: nothing, once the load is found (`6 / bandwidth`)."""
        del speed
        return 0.0


SLOW = 1e-3
"""Of bandwidth times interval: below it a sampled loop is a continuous one."""


def _tracked(p: TrackingParams, state: TrackingState, angle: float) -> tuple[float, float, float]:
    """`tracking_step` in plain numbers, so that a data sheet compiles nothing."""
    predicted = state.angle + p.dt * (state.speed + 0.5 * p.dt * state.load)
    error = angle - predicted
    speed = state.speed + p.dt * state.load + p.speed_gain * error
    return predicted + p.angle_gain * error, speed, state.load + p.load_gain * error
