"""Conformance of every regulator with an integral: no windup, bumpless start, limits held. Then the PI itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.control import (
    AccelerationParams,
    CurrentParams,
    PiParams,
    SpeedParams,
    acceleration_step,
    current_step,
    pi_start,
    pi_step,
    speed_step,
)

PI = PiParams(gain=2.0, integral_gain=0.05)
CURRENT = CurrentParams(17.0, 0.7, 40.0, 0.189)
SPEED = SpeedParams(0.9, 0.03, 8.25, 40.0, 0.189, 1.0 / 2.1)
ACCELERATION = AccelerationParams(4800.0, 120.0, 64.0, 60.0)


@dataclass(frozen=True)
class Regulator:
    """A regulator brought to one form: `step(integral, error) -> (output, integral)`."""

    step: Callable[[float, float], tuple[float, float]]
    limit: float
    gain: float
    integral_gain: float


REGULATORS = {
    "pi": Regulator(lambda i, e: pi_step(PI, i, e, 0.0, -10.0, 10.0), 10.0, PI.gain, PI.integral_gain),
    "current": Regulator(lambda i, e: current_step(CURRENT, i, e, 0.0, 0.0), 40.0, CURRENT.gain, CURRENT.integral_gain),
    "speed": Regulator(lambda i, e: speed_step(SPEED, i, e, 0.0, 0.0), 8.25, SPEED.gain, SPEED.integral_gain),
    "acceleration": Regulator(lambda i, e: acceleration_step(ACCELERATION, i, e, 0.0, 0.0, False), 60.0, 4800.0, 64.0),
}
every = pytest.mark.parametrize("regulator", REGULATORS.values(), ids=REGULATORS)


@every
@given(errors=st.lists(st.floats(-1e4, 1e4), max_size=40))
def test_limits_are_held(regulator: Regulator, errors: list[float]) -> None:
    integral = 0.0
    for error in errors:
        output, integral = regulator.step(integral, error)
        assert abs(output) <= regulator.limit
        assert math.isfinite(integral)


@every
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_long_saturation_is_forgotten_as_soon_as_the_error_turns(regulator: Regulator, side: float) -> None:
    integral, error = 0.0, 3.0 * side * regulator.limit / regulator.gain
    for _ in range(100_000):
        output, integral = regulator.step(integral, error)
    assert output == side * regulator.limit
    output, _ = regulator.step(integral, -0.2 * error)
    assert side * output < 0.9 * regulator.limit


@every
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("part", [-0.6, 0.0, 0.6])
def test_a_single_wrong_reading_does_not_throw_the_output_to_the_other_limit(
    regulator: Regulator, side: float, part: float
) -> None:
    integral = part * regulator.limit
    spike, integral = regulator.step(integral, 10.0 * side * regulator.limit / regulator.gain)
    assert spike == side * regulator.limit
    for _ in range(3):
        output, integral = regulator.step(integral, 0.0)
        assert output == pytest.approx(part * regulator.limit, abs=1e-12 * regulator.limit)


@every
def test_without_error_the_output_stays(regulator: Regulator) -> None:
    integral = 0.3 * regulator.limit
    for _ in range(100):
        output, integral = regulator.step(integral, 0.0)
    assert output == pytest.approx(0.3 * regulator.limit, rel=1e-12)


@every
@pytest.mark.parametrize("part", [-0.7, 0.0, 0.4])
@pytest.mark.parametrize("error", [0.0, 0.02, -0.1])
def test_bumpless_start(regulator: Regulator, part: float, error: float) -> None:
    """Whatever the output was by hand and whatever the error is, the first automatic output is the same."""
    by_hand = part * regulator.limit
    pi = PiParams(regulator.gain, regulator.integral_gain)
    output, _ = regulator.step(pi_start(pi, by_hand, error, 0.0), error)
    assert output == pytest.approx(by_hand, rel=1e-9, abs=1e-9)


def test_pi_is_the_velocity_form() -> None:
    """Specification 04.1, Td = 0, with the newest error in the integral: du = (Kc + Ki) e_k - Kc e_(k-1)."""
    errors = np.random.default_rng(4).normal(size=200)
    integral, outputs = 0.0, []
    for error in errors:
        output, integral = pi_step(PI, integral, error, 0.0, -1e9, 1e9)
        outputs.append(output)
    before = np.concatenate([[0.0], errors[:-1]])
    moves = (PI.gain + PI.integral_gain) * errors - PI.gain * before
    np.testing.assert_allclose(outputs, np.cumsum(moves), rtol=1e-12, atol=1e-12)


def test_feed_forward_is_added_inside_the_limits() -> None:
    assert pi_step(PI, 0.0, 0.0, 3.0, -10.0, 10.0) == (3.0, 0.0)
    assert pi_step(PI, 0.0, 0.0, 30.0, -10.0, 10.0) == (10.0, 0.0)
    assert current_step(CURRENT, 0.0, 1.0, 1.0, 100.0)[0] == pytest.approx(18.9)
    assert speed_step(SPEED, 0.0, 5.0, 5.0, 2.5)[0] == pytest.approx(2.5)


def test_the_current_reference_stays_within_what_the_supply_can_drive() -> None:
    speed = 180.0
    available = (40.0 - 0.189 * speed) / 2.1
    assert available < 8.25
    assert speed_step(SPEED, 0.0, 1000.0, speed, 0.0)[0] == pytest.approx(available)
    assert speed_step(SPEED, 0.0, -1000.0, speed, 0.0)[0] == -8.25
    assert speed_step(SPEED, 0.0, -1000.0, -speed, 0.0)[0] == pytest.approx(-available)
    assert speed_step(SPEED, 0.0, 1000.0, 1e6, 0.0)[0] == -8.25


def test_the_acceleration_integral_stands_still_while_the_drive_is_saturated() -> None:
    assert acceleration_step(ACCELERATION, 1.5, 1e-3, 0.0, 0.0, True)[1] == 1.5
    assert acceleration_step(ACCELERATION, 1.5, 1e-3, 0.0, 0.0, False)[1] > 1.5
