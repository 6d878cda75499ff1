"""Homing by a reference or limit switch, which knows the turn of the motor, and the index, which knows where in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.devices.encoders.homing.states import HomingState, homing_done, homing_failed, homing_state, later
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["SwitchHoming", "SwitchParams", "switch_step"]


class SwitchParams(NamedTuple):
    """Numbers of a homing by switch and index.

    Counts per turn; the home index's position and its distance from where the switch opens, and what that may be off
    by; travels to the switch and out of it; speeds to the switch and out of it, counts/s; samples to give up after.
    """

    counts_per_rev: int
    index_position: int
    distance: float
    tolerance: float
    travel: int
    width: int
    search_speed: float
    leave_speed: float
    samples: int


@dataclass(frozen=True, slots=True)
class SwitchHoming:
    """Onto the switch, off it slowly, on to the next index.

    Raises
    ------
    ModelError
        A field outside its range; a speed of 0; a distance and tolerance that leave the turn in doubt.
    """

    counts_per_rev: int = parameter(meaning="counts per turn of the motor", least=4, example=4000)
    travel: int = parameter(meaning="longest way to the switch, counts", least=1, example=400_000)
    index_position: int = parameter(0, meaning="position of the home index, counts")
    distance: float = parameter(
        0.5, meaning="from where the switch opens to the home index, turns of the motor", least=0.0, most=1.0
    )
    tolerance: float = parameter(0.25, meaning="of that distance, turns of the motor", above=0.0, below=0.5)
    width: int = parameter(40_000, meaning="longest way out of the switch, counts", least=1)
    search_speed: float = parameter(-20_000.0, meaning="to the switch, its sign the direction, counts/s")
    leave_speed: float = parameter(4_000.0, meaning="out of the switch and to the index, counts/s", above=0.0)
    time_limit: float = parameter(60.0, meaning="time after which it gives up", unit="s", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.search_speed == 0.0:
            raise ModelError("SwitchHoming: search_speed is 0; it must be another number, its sign the direction")
        if not self.tolerance <= self.distance <= 1.0 - self.tolerance:
            raise ModelError(
                f"SwitchHoming: distance is {self.distance:g} turns with a tolerance of {self.tolerance:g}; the "
                f"index must stay clear of the switch, distance within {self.tolerance:g} to {1.0 - self.tolerance:g}: "
                "move the switch"
            )

    def params(self, dt: float) -> SwitchParams:
        """Params of `switch_step`, stepped each `dt` (s)."""
        require("SwitchHoming.params", "dt", dt, above=0.0)
        return SwitchParams(
            self.counts_per_rev,
            self.index_position,
            self.distance * self.counts_per_rev,
            self.tolerance * self.counts_per_rev,
            self.travel,
            self.width,
            self.search_speed,
            -math.copysign(self.leave_speed, self.search_speed),
            math.ceil(self.time_limit / dt),
        )


@loop
def switch_step(
    params: SwitchParams, state: HomingState, count: int, pulses: int, index_count: int, closed: bool
) -> HomingState:
    """One sample: count, index pulses and the count latched at the last one, whether the switch is closed.

    A switch that is closed at the start is left first (`BACKING_OFF`); then `SEARCHING` until it closes, `LEAVING`
    until it opens, `TO_INDEX`. `MISSING_SWITCH`, `STUCK_SWITCH`: it does not close, or open, on the longest way;
    `MISSING_INDEX`: none within a turn and a quarter; `WRONG_TURN`: the index lies elsewhere from the switch than at
    commissioning, so that it may be its neighbour; `TIME_OUT`: the axis does not get there. A switch that has moved by
    whole turns of the motor is not told.
    """
    if state.phase >= 5:
        return state
    state = later(state)
    moved = abs(count - state.mark)
    if state.samples > params.samples:
        return homing_failed(state, 1)
    if state.phase == 0:
        if closed:
            return homing_state(state, 1, count, pulses, 0.0, params.leave_speed)
        return homing_state(state, 2, count, pulses, 0.0, params.search_speed)
    if state.phase == 1:
        if not closed:
            return homing_state(state, 2, count, pulses, 0.0, params.search_speed)
        return homing_failed(state, 5) if moved > params.width else state
    if state.phase == 2:
        if closed:
            return homing_state(state, 3, count, pulses, 0.0, params.leave_speed)
        return homing_failed(state, 4) if moved > params.travel else state
    if state.phase == 3:
        if not closed:
            return homing_state(state, 4, count, pulses, 0.0, params.leave_speed)
        return homing_failed(state, 5) if moved > params.width else state
    if pulses != state.pulses:
        if abs(abs(index_count - state.mark) - params.distance) > params.tolerance:
            return homing_failed(state, 2)
        return homing_done(state, params.index_position - index_count)
    return homing_failed(state, 3) if 4 * moved > 5 * params.counts_per_rev else state
