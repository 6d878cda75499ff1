"""The encoder: quantisation, the 16-bit counter, and the ways to a speed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import (
    Encoder,
    TrackingState,
    count_angle,
    difference_speed,
    encoder_counter,
    extend_counter,
    tracking_params,
    tracking_step,
)
from holonom.errors import ModelError

ENCODER = Encoder(1000)
PARAMS = ENCODER.params()
DT = 1e-4


@given(st.floats(-1e5, 1e5))
def test_the_counter_holds_the_low_16_bits_of_the_floor(angle: float) -> None:
    count = math.floor(angle * PARAMS.counts_per_rad)
    assert encoder_counter(PARAMS, angle) == count % 65536


@given(start=st.integers(-(2**40), 2**40), moves=st.lists(st.integers(-(2**15), 2**15 - 1), max_size=30))
def test_extension_is_exact_for_any_motion_below_half_the_counter(start: int, moves: list[int]) -> None:
    true = extended = start
    for move in moves:
        true += move
        extended = extend_counter(extended, true % 65536)
        assert extended == true


@given(total=st.integers(-(2**40), 2**40), counter=st.integers(0, 65535))
def test_extension_agrees_with_a_16_bit_subtraction(total: int, counter: int) -> None:
    step = np.array([counter - total % 65536]).astype(np.int16)[0]
    assert extend_counter(total, counter) == total + int(step)


@given(st.floats(-1000.0, 1000.0))
def test_the_angle_comes_back_within_half_a_count(angle: float) -> None:
    total = extend_counter(math.floor(angle * PARAMS.counts_per_rad) - 3, encoder_counter(PARAMS, angle))
    assert abs(count_angle(PARAMS, total) - angle) <= 0.5 * PARAMS.resolution * (1.0 + 1e-6)


@pytest.mark.parametrize(("part", "right"), [(0.999, True), (1.001, False)])
@pytest.mark.parametrize("speed", [300.0, -300.0])
def test_the_longest_read_interval_is_half_of_the_counter(part: float, right: bool, speed: float) -> None:
    interval = part * ENCODER.longest_read_interval(abs(speed))
    total = 0
    for k in range(1, 20):
        total = extend_counter(total, encoder_counter(PARAMS, speed * interval * k))
    true = math.floor(speed * interval * 19 * PARAMS.counts_per_rad)
    assert (total == true) is right


def test_the_longest_read_interval_by_hand() -> None:
    """Specification 03.3, erratum: 2^15 / f_max; 50 turns a second of 1000 counts are 50 kHz."""
    assert ENCODER.longest_read_interval(100.0 * math.pi) == pytest.approx(2**15 / 50e3)


def test_m_method_by_hand() -> None:
    """37 counts of 1000 in 0.5 ms are 74 turns a second; one count is 2 turns a second."""
    assert difference_speed(PARAMS, 37, 5e-4) == pytest.approx(74.0 * 2.0 * math.pi)
    assert ENCODER.speed_resolution(5e-4) == pytest.approx(4.0 * math.pi)


def run_tracking(bandwidth: float, angle: np.ndarray, acceleration: np.ndarray | float) -> np.ndarray:
    params = tracking_params(bandwidth, DT)
    known = np.broadcast_to(acceleration, angle.shape)
    state, rows = TrackingState(float(angle[0]), 0.0, 0.0), []
    for value, push in zip(angle, known, strict=True):
        state = tracking_step(params, state, float(value), float(push))
        rows.append(state)
    return np.array(rows)


@given(st.floats(50.0, 3000.0))
def test_the_three_poles_lie_where_the_bandwidth_says(bandwidth: float) -> None:
    params = tracking_params(bandwidth, DT)
    columns = [tracking_step(params, TrackingState(*row), 0.0, 0.0) for row in np.eye(3)]
    polynomial = np.poly(np.array(columns).T)
    np.testing.assert_allclose(polynomial, np.poly([math.exp(-bandwidth * DT)] * 3), atol=1e-9)


def test_known_acceleration_leaves_no_delay() -> None:
    t = DT * np.arange(4000)
    acceleration = 300.0 * np.sin(40.0 * t)
    speed = np.concatenate([[0.0], np.cumsum(acceleration * DT)])[:-1]
    angle = np.concatenate([[0.0], np.cumsum(speed * DT + 0.5 * acceleration * DT**2)])[:-1]
    before = np.concatenate([[0.0], acceleration[:-1]])  # what acted since the last read
    informed = run_tracking(400.0, angle, before)[:, 1]
    blind = run_tracking(400.0, angle, 0.0)[:, 1]
    assert np.abs(informed - speed).max() < 1e-9
    assert np.abs(blind - speed).max() > 0.1


def test_a_wrong_acceleration_does_not_bias_the_speed() -> None:
    t = DT * np.arange(3000)
    state = run_tracking(400.0, 20.0 * t, 55.0)[-1]
    assert state[1] == pytest.approx(20.0, abs=1e-6)
    assert state[2] == pytest.approx(-55.0, abs=1e-4)


def test_one_count_costs_0_8_bandwidths() -> None:
    angle = np.zeros(1000)
    angle[10:] = 1.0
    peak = run_tracking(400.0, angle, 0.0)[:, 1].max() / 400.0
    assert peak == pytest.approx(0.8, rel=0.02)


def test_the_observer_is_far_finer_than_the_m_method() -> None:
    speed = 7.0
    counts = np.floor(speed * DT * np.arange(8000) * PARAMS.counts_per_rad)
    observed = run_tracking(400.0, (counts + 0.5) * PARAMS.resolution, 0.0)[4000:, 1]
    differences = [difference_speed(PARAMS, int(n), 5e-4) for n in np.diff(counts[4000::5])]
    assert np.std(differences) > 3.0
    assert np.std(observed) < 0.1 * np.std(differences)
    assert observed.mean() == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Encoder(0), "counts_per_rev is 0; it must be finite and at least 1"),
        (lambda: ENCODER.longest_read_interval(0.0), "max_speed is 0"),
        (lambda: ENCODER.speed_resolution(-1.0), "interval is -1"),
        (lambda: tracking_params(0.0, DT), "bandwidth is 0"),
        (lambda: tracking_params(100.0, math.nan), "dt is nan"),
    ],
)
def test_bad_numbers_are_named(make: object, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()  # type: ignore[operator]
