"""Homing on a simulated axis: the position comes out right from anywhere, and each way to fail is named."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import (
    HEALTHY,
    HOMING_START,
    HomingFault,
    HomingPhase,
    HomingState,
    LineFaults,
    PotentiometerHoming,
    QuadratureEncoder,
    SwitchHoming,
    line_faults,
    potentiometer_step,
    quadrature_step,
    switch_step,
)
from holonom.errors import ModelError

ENCODER = QuadratureEncoder(50)
TURN = 200
DT = 1e-2
POT = PotentiometerHoming(
    TURN, counts_per_volt=-1000.0, zero_voltage=0.3, index_position=37, speed=500.0, lowest=-5.0, highest=5.0
)
SWITCH = SwitchHoming(
    TURN,
    travel=4000,
    index_position=-1000,
    distance=0.4,
    tolerance=0.2,
    width=600,
    search_speed=-2000.0,
    leave_speed=300.0,
    time_limit=20.0,
)


@dataclass
class Axis:
    """Position in counts, 0 where the truth has it; index pulses at `index` + a whole number of turns."""

    position: float
    index: int
    faults: LineFaults = HEALTHY
    jammed: bool = False

    def __post_init__(self) -> None:
        self.state = ENCODER.start(self.angle)

    @property
    def angle(self) -> float:
        return (self.position - self.index + 0.5) * math.tau / TURN

    def move(self, speed: float) -> tuple[int, int, int]:
        self.position += 0.0 if self.jammed else speed * DT
        self.state = quadrature_step(ENCODER.params(), self.faults, self.state, self.angle)
        return self.state.counts, self.state.pulses, self.state.index_count


def home_by_potentiometer(way: PotentiometerHoming, axis: Axis, error: float = 0.0) -> HomingState:
    state, params = HOMING_START, way.params(DT)
    for _ in range(1000):
        count, pulses, latched = axis.move(state.speed)
        reading = way.zero_voltage + (axis.position + error * TURN) / way.counts_per_volt
        state = potentiometer_step(params, state, count, pulses, latched, reading)
        if state.phase >= HomingPhase.DONE:
            return state
    raise AssertionError("it does not end")


def home_by_switch(way: SwitchHoming, axis: Axis, switch: Any) -> HomingState:
    state, params = HOMING_START, way.params(DT)
    for _ in range(5000):
        count, pulses, latched = axis.move(state.speed)
        state = switch_step(params, state, count, pulses, latched, switch(axis.position))
        if state.phase >= HomingPhase.DONE:
            return state
    raise AssertionError("it does not end")


def at_the_end(position: float) -> bool:
    """Closed below the home index, 0.4 turns before it."""
    return -1500.0 < position < -1000.0 - 0.4 * TURN


def is_home(state: HomingState, axis: Axis) -> bool:
    assert (state.phase, state.fault, state.speed) == (HomingPhase.DONE, HomingFault.NONE, 0.0)
    return abs(axis.state.counts + state.offset - axis.position) <= 0.5 + 1e-9


@given(start=st.floats(-3000.0, 3000.0), error=st.floats(-0.095, 0.095), back=st.booleans())
def test_a_potentiometer_and_an_index_give_the_position(start: float, error: float, back: bool) -> None:
    axis = Axis(start, POT.index_position)
    way = replace(POT, speed=-500.0) if back else POT
    assert is_home(home_by_potentiometer(way, axis, error), axis)


@given(start=st.floats(-2900.0, 3000.0), error=st.floats(0.11, 0.89))
def test_a_potentiometer_beyond_its_error_is_the_wrong_turn(start: float, error: float) -> None:
    state = home_by_potentiometer(POT, Axis(start, POT.index_position), error)
    assert (state.phase, state.fault, state.speed) == (HomingPhase.FAILED, HomingFault.WRONG_TURN, 0.0)


@pytest.mark.parametrize(
    ("axis", "error", "fault"),
    [
        (Axis(100.0, 37, line_faults(index="low")), 0.0, HomingFault.MISSING_INDEX),
        (Axis(100.0, 37, line_faults(dead=True)), 0.0, HomingFault.APART),
        (Axis(100.0, 37, line_faults(swapped=True)), 0.0, HomingFault.APART),
        (Axis(100.0, 37, line_faults(b="high")), 0.0, HomingFault.APART),
        (Axis(100.0, 37, jammed=True), 0.0, HomingFault.TIME_OUT),
        (Axis(100.0, 37), 30.0, HomingFault.NO_SIGNAL),
        (Axis(100.0, 37), math.nan, HomingFault.NO_SIGNAL),
    ],
)
def test_the_potentiometer_way_names_what_failed(axis: Axis, error: float, fault: HomingFault) -> None:
    state = home_by_potentiometer(POT, replace(axis), error)
    assert (state.phase, state.fault, state.speed) == (HomingPhase.FAILED, fault, 0.0)
    assert state.samples < 60 or fault == HomingFault.TIME_OUT


def test_a_failed_homing_stays_failed_and_a_done_one_done() -> None:
    for phase in (HomingPhase.DONE, HomingPhase.FAILED):
        state = HomingState(int(phase), 0, 5, 0, 0, 0.0, 0.0, 12)
        assert potentiometer_step(POT.params(DT), state, 5, 5, 5, math.nan) == state
        assert switch_step(SWITCH.params(DT), state, 5, 5, 5, True) == state


@given(start=st.floats(-1490.0, 2500.0))
def test_a_switch_and_an_index_give_the_position(start: float) -> None:
    """From either side, and from on the switch."""
    axis = Axis(start, SWITCH.index_position)
    assert is_home(home_by_switch(SWITCH, axis, at_the_end), axis)


@given(start=st.floats(-2500.0, 1490.0))
def test_a_switch_at_the_other_end_is_the_mirror_image(start: float) -> None:
    way = replace(SWITCH, search_speed=2000.0, index_position=1000)
    axis = Axis(start, 1000)
    assert is_home(home_by_switch(way, axis, lambda position: at_the_end(-position)), axis)


def shifted(turns: float) -> Any:
    return lambda position: at_the_end(position - turns * TURN)


@pytest.mark.parametrize(
    ("start", "faults", "switch", "fault"),
    [
        (500.0, HEALTHY, lambda position: False, HomingFault.MISSING_SWITCH),
        (500.0, HEALTHY, lambda position: True, HomingFault.STUCK_SWITCH),
        (500.0, line_faults(index="low"), at_the_end, HomingFault.MISSING_INDEX),
        (500.0, line_faults(index="high"), at_the_end, HomingFault.MISSING_INDEX),
        (500.0, HEALTHY, shifted(0.3), HomingFault.WRONG_TURN),
        (500.0, HEALTHY, shifted(-0.3), HomingFault.WRONG_TURN),
        (500.0, line_faults(dead=True), lambda position: False, HomingFault.TIME_OUT),
    ],
)
def test_the_switch_way_names_what_failed(start: float, faults: LineFaults, switch: Any, fault: HomingFault) -> None:
    state = home_by_switch(SWITCH, Axis(start, SWITCH.index_position, faults), switch)
    assert (state.phase, state.fault, state.speed) == (HomingPhase.FAILED, fault, 0.0)


def test_a_switch_that_moved_by_a_turn_is_not_told() -> None:
    """A limit of this way, which the other one has not."""
    axis = Axis(500.0, SWITCH.index_position)
    assert not is_home(home_by_switch(SWITCH, axis, shifted(1.0)), axis)
    assert is_home(home_by_switch(SWITCH, axis, at_the_end), axis)


def test_a_switch_that_does_not_open_again_is_stuck() -> None:
    pressed = []

    def sticks(position: float) -> bool:
        pressed.append(at_the_end(position))
        return any(pressed)

    state = home_by_switch(SWITCH, Axis(500.0, SWITCH.index_position), sticks)
    assert state.fault == HomingFault.STUCK_SWITCH


@given(jammed_after=st.integers(0, 300))
def test_an_axis_that_jams_times_out_wherever_it_is(jammed_after: int) -> None:
    axis, state, params = Axis(500.0, SWITCH.index_position), HOMING_START, SWITCH.params(DT)
    for k in range(3000):
        axis.jammed = k >= jammed_after
        state = switch_step(params, state, *axis.move(state.speed), at_the_end(axis.position))
        if state.phase >= HomingPhase.DONE:
            break
    assert state.phase == HomingPhase.DONE or state.fault == HomingFault.TIME_OUT
    assert state.samples <= 2001


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: replace(POT, error=0.5), "error is 0.5; it must be finite and greater than 0 and less than 0.5"),
        (lambda: replace(POT, speed=0.0), "speed is 0; it must be another number"),
        (lambda: replace(POT, counts_per_volt=0.0), "counts_per_volt is 0"),
        (lambda: replace(POT, lowest=6.0), "lowest is 6 V; it must be below highest, 5 V"),
        (lambda: POT.params(0.0), "dt is 0.0"),
        (lambda: replace(SWITCH, search_speed=0.0), "search_speed is 0"),
        (lambda: replace(SWITCH, distance=0.1), "the index must stay clear of the switch, distance within 0.2 to 0.8"),
        (lambda: replace(SWITCH, time_limit=math.inf), "time_limit is inf"),
        (lambda: SWITCH.params(math.nan), "dt is nan"),
    ],
)
def test_bad_numbers_are_named(make: Any, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()
