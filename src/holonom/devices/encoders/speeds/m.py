"""M method: counts in an interval, `w = dN q / T_s`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from holonom.devices.encoders.speeds.readings import EdgeReading
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["MMethod", "MParams", "MState", "m_step"]


class MParams(NamedTuple):
    """Speed of one count in an interval, rad/s."""

    unit: float


class MState(NamedTuple):
    """Speed, rad/s; count at the last sample."""

    speed: float
    counts: int


@loop
def m_step(params: MParams, state: MState, reading: EdgeReading) -> MState:
    """One sample."""
    return MState((reading.counts - state.counts) * params.unit, reading.counts)


@dataclass(frozen=True, slots=True)
class MMethod:
    """Counts in an interval.

    Raises
    ------
    ModelError
        A field outside its range.
    """

    counts_per_rev: int = parameter(meaning="counts per turn after decoding", least=1, example=4000)
    interval: float = parameter(5e-4, meaning="between two samples", unit="s", above=0.0)
    step: ClassVar[Callable[..., Any]] = staticmethod(m_step)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self) -> MParams:
        """Params of `m_step`."""
        return MParams(2.0 * math.pi / self.counts_per_rev / self.interval)

    def start(self, reading: EdgeReading) -> MState:
        """State at a first reading, at rest."""
        return MState(0.0, reading.counts)

    def resolution(self, speed: float) -> float:
        """Step (rad/s) between two values, `q / T_s`, at any speed (rad/s)."""
        del speed
        return self.params().unit

    def delay(self, speed: float) -> float:
        """Age (s) of the value: it is the mean of the interval, `T_s / 2`, at any speed (rad/s)."""
        del speed
        return 0.5 * self.interval
