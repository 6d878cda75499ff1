"""Friction and gear."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import Friction, Gear, friction_torque, gear_torque
from holonom.errors import ModelError

speeds = st.floats(-500.0, 500.0)
WAIST = Friction(1.48e-3, 0.395, 0.435)  # Puma 560, joint 1, at the motor (Armstrong 1986)


@given(speeds)
def test_friction_never_gives_energy(speed: float) -> None:
    assert friction_torque(WAIST.params(0.1), speed) * speed >= 0.0


def test_friction_far_from_standstill_is_viscous_plus_coulomb() -> None:
    params = WAIST.params(1e-3)
    assert friction_torque(params, 50.0) == pytest.approx(1.48e-3 * 50.0 + 0.395, rel=1e-6)
    assert friction_torque(params, -50.0) == pytest.approx(-1.48e-3 * 50.0 - 0.435, rel=1e-6)
    assert friction_torque(params, 0.0) == 0.0


@given(speeds, speeds)
def test_friction_grows_with_speed(a: float, b: float) -> None:
    params = WAIST.params(0.05)
    low, high = min(a, b), max(a, b)
    assert friction_torque(params, low) <= friction_torque(params, high)


def test_below_breakaway_the_shaft_creeps_as_documented() -> None:
    smoothing, torque = 0.2, 0.3
    creep = smoothing * torque / math.sqrt(0.395**2 - torque**2)
    params = Friction(0.0, 0.395, 0.435).params(smoothing)
    assert friction_torque(params, creep) == pytest.approx(torque, rel=1e-12)


def coast(smoothing: float, inertia: float, dt: float) -> list[float]:
    params, speeds = Friction(0.0, 0.4, 0.4).params(smoothing), [1.0]
    for _ in range(400):
        speeds.append(speeds[-1] - dt * friction_torque(params, speeds[-1]) / inertia)
    return speeds


def test_the_smallest_smoothing_comes_to_rest_and_a_third_of_it_chatters() -> None:
    inertia, dt = 9e-4, 1e-4
    least = Friction(0.0, 0.4, 0.4).smallest_smoothing(inertia, dt)
    assert abs(coast(least, inertia, dt)[-1]) < 1e-6
    chattering = coast(least / 3.0, inertia, dt)
    assert abs(chattering[-1]) > 1e-3
    assert chattering[-1] * chattering[-2] < 0.0


@given(ratio=st.sampled_from([-62.61, 107.82]), efficiency=st.floats(0.3, 1.0), torque=speeds, speed=speeds)
def test_a_gear_loses_power_in_both_directions(ratio: float, efficiency: float, torque: float, speed: float) -> None:
    motor_power = torque * speed
    joint_power = gear_torque(Gear(ratio, efficiency).params(), torque, speed) * speed / ratio
    if motor_power >= 0.0:
        assert joint_power == pytest.approx(efficiency * motor_power)
    else:  # driven back: what the joint puts in, times the efficiency, arrives at the motor
        assert joint_power * efficiency == pytest.approx(motor_power)


def test_a_gear_with_a_negative_ratio_turns_the_torque() -> None:
    assert gear_torque(Gear(-62.61).params(), 1.0, 5.0) == -62.61


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: Gear(0.0), "ratio is 0"),
        (lambda: Gear(math.nan), "ratio is nan"),
        (lambda: Gear(10.0, 0.0), "efficiency is 0"),
        (lambda: Gear(10.0, 1.2), "efficiency is 1.2; it must be finite and greater than 0 and at most 1"),
        (lambda: Friction(-1e-3), "viscous is -0.001; it must be finite and at least 0"),
        (lambda: Friction(0.0, math.inf), "coulomb_positive is inf"),
        (lambda: Friction(0.0, 0.1, -0.4), "coulomb_negative is -0.4"),
        (lambda: Friction(0.0, 0.1, 0.1).params(0.0), "smoothing is 0"),
    ],
)
def test_bad_numbers_are_named(make: object, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()  # type: ignore[operator]
