"""Homing by a potentiometer, which knows the turn of the motor, and the index, which knows where in it (spec 03.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.devices.encoders.homing.states import HomingState, homing_done, homing_failed, homing_state, later
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["PotentiometerHoming", "PotentiometerParams", "potentiometer_step"]


class PotentiometerParams(NamedTuple):
    """Numbers of a homing by potentiometer and index.

    Counts per turn; an index's position; position = zero + slope x reading, counts; readings that are possible;
    counts that potentiometer and index may differ by; speed, counts/s; samples after which it gives up.
    """

    counts_per_rev: int
    index_position: int
    zero: float
    slope: float
    low: float
    high: float
    tolerance: float
    speed: float
    samples: int


@dataclass(frozen=True, slots=True)
class PotentiometerHoming:
    """A potentiometer on the axis tells the motor's turn, a short move to the next index the rest.

    Raises
    ------
    ModelError
        A field outside its range; a potentiometer that is not linear to half a turn: it cannot tell the turn; a
        range of readings that is none.
    """

    counts_per_rev: int = parameter(meaning="counts per turn of the motor", least=4, example=4000)
    counts_per_volt: float = parameter(meaning="slope of the potentiometer, signed", unit="1/V", example=40000.0)
    zero_voltage: float = parameter(0.0, meaning="reading at position 0", unit="V")
    index_position: int = parameter(0, meaning="position of any one index, counts")
    lowest: float = parameter(-10.0, meaning="reading below which a wire is broken", unit="V")
    highest: float = parameter(10.0, meaning="reading above which a wire is broken", unit="V")
    error: float = parameter(0.1, meaning="greatest, of the potentiometer, turns of the motor", above=0.0, below=0.5)
    speed: float = parameter(4000.0, meaning="of the move to the index, its sign the direction, counts/s")
    time_limit: float = parameter(5.0, meaning="time after which it gives up", unit="s", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        for name in ("speed", "counts_per_volt"):
            if getattr(self, name) == 0.0:
                raise ModelError(f"PotentiometerHoming: {name} is 0; it must be another number, its sign the direction")
        if self.lowest >= self.highest:
            raise ModelError(
                f"PotentiometerHoming: lowest is {self.lowest:g} V; it must be below highest, {self.highest:g} V"
            )

    def params(self, dt: float) -> PotentiometerParams:
        """Params of `potentiometer_step`, stepped each `dt` (s)."""
        require("PotentiometerHoming.params", "dt", dt, above=0.0)
        return PotentiometerParams(
            self.counts_per_rev,
            self.index_position,
            -self.zero_voltage * self.counts_per_volt,
            self.counts_per_volt,
            self.lowest,
            self.highest,
            self.error * self.counts_per_rev,
            self.speed,
            math.ceil(self.time_limit / dt),
        )


@loop
def potentiometer_step(
    params: PotentiometerParams, state: HomingState, count: int, pulses: int, index_count: int, reading: float
) -> HomingState:
    """One sample: count, index pulses and the count latched at the last one, reading of the potentiometer (V).

    `TO_INDEX` at `params.speed` until an index comes; the potentiometer says which one it was. `WRONG_TURN`: index and
    potentiometer differ by more than its error, so that the turn is in doubt; `MISSING_INDEX`: more than a turn and a
    quarter without one; `APART`: potentiometer and counter move apart (swapped channels, no counts, a coupling that
    slips); `NO_SIGNAL`: a reading that no potentiometer gives; `TIME_OUT`: the axis does not get there.
    """
    if state.phase >= 5:
        return state
    state = later(state)
    if not params.low <= reading <= params.high:
        return homing_failed(state, 6)
    coarse = params.zero + params.slope * reading
    if state.phase == 0:
        return homing_state(state, 4, count, pulses, coarse, params.speed)
    if abs(coarse - state.coarse - (count - state.mark)) > 2.0 * params.tolerance:
        return homing_failed(state, 7)
    if pulses != state.pulses:
        there = coarse - (count - index_count)
        turns = math.floor((there - params.index_position) / params.counts_per_rev + 0.5)
        position = params.index_position + turns * params.counts_per_rev
        if abs(there - position) > params.tolerance:
            return homing_failed(state, 2)
        return homing_done(state, position - index_count)
    if 4 * abs(count - state.mark) > 5 * params.counts_per_rev:
        return homing_failed(state, 3)
    if state.samples > params.samples:
        return homing_failed(state, 1)
    return state
