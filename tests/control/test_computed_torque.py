"""Computed torque of one axis: a pendulum behind motor, gear and encoder, the law at 1 kHz."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from one_axis import DT, INERTIA, Axis, puma_axis

from holonom.control import (
    AccelerationParams,
    acceleration_params,
    acceleration_step,
    current_step,
    least_inertia,
    torque_to_current,
)
from holonom.devices import (
    TrackingState,
    armature_step,
    count_angle,
    encoder_counter,
    extend_counter,
    friction_torque,
    stiction_step,
    tracking_step,
)
from holonom.errors import OutOfLimits
from holonom.trace.code.loops import loop

WEIGHT = 40.0  # N m, of the pendulum stretched out


@loop
def _loop(axis, law, model_inertia, model_weight, q_ref, qd_ref, qdd_ref, max_current, weight, out):
    nu = axis.gear.ratio
    q, qd, current, voltage_integral, integral, wanted, held = q_ref[0], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    saturated = False
    total = np.int64(math.floor(nu * q * axis.encoder.counts_per_rad))
    shaft = TrackingState(nu * q, 0.0, 0.0)
    for tick in range(10 * len(q_ref)):
        k = tick // 10
        total = extend_counter(total, encoder_counter(axis.encoder, nu * q))
        angle = count_angle(axis.encoder, total)
        if tick % 10 == 0:
            position, speed = angle / nu, shaft.speed / nu
            u, integral = acceleration_step(
                law, integral, q_ref[k] - position, qd_ref[k] - speed, qdd_ref[k], saturated
            )
            rubbing = nu * friction_torque(axis.known_friction, nu * qd_ref[k])
            torque = model_inertia * u + model_weight * math.cos(position) + rubbing
            wanted, saturated = torque_to_current(torque, nu * axis.torque_constant, max_current)
        voltage, voltage_integral = current_step(axis.current, voltage_integral, wanted, current, shaft.speed)
        after = armature_step(axis.armature, current, voltage, nu * qd)
        rubbed, held = stiction_step(axis.friction, held, nu * qd)
        shaft_torque = axis.torque_constant * 0.5 * (current + after) - rubbed
        shaft = tracking_step(axis.tracking, shaft, angle, axis.torque_constant * current / axis.assumed_inertia)
        out[tick] = q
        current = after
        qd += DT * (nu * shaft_torque - weight * math.cos(q)) / axis.inertia
        q += DT * qd


def track(
    axis: Axis,
    law: AccelerationParams,
    reference: tuple[np.ndarray, ...],
    *,
    model: float = 1.0,
    max_current: float = 8.25,
) -> np.ndarray:
    """Joint error per 1 ms of the pendulum; `model` scales the inertia and weight that the law believes in."""
    out = np.zeros(10 * len(reference[0]))
    _loop(axis, law, model * INERTIA[0], model * WEIGHT, *reference, max_current, WEIGHT, out)
    return reference[0] - out[::10]


def wave(seconds: float) -> tuple[np.ndarray, ...]:
    """A smooth swing that rests at both ends, and 0.5 s of rest: position, speed, acceleration at 1 kHz."""
    t = np.minimum(np.arange(0.0, seconds + 0.5, 1e-3), seconds)
    w = 2.0 * math.pi / seconds
    inside = t < seconds
    q, qd = 0.4 * (1.0 - np.cos(w * t)), 0.4 * w * np.sin(w * t)
    return q, qd * inside, 0.4 * w * w * np.cos(w * t) * inside


def ideal_error(law: AccelerationParams, dt: float, steps: int) -> np.ndarray:
    """Error of a perfectly linearised axis, q'' = u, held between the samples of the law."""
    error, rate, integral, errors = 1e-3, 0.0, 0.0, []
    for _ in range(steps):
        errors.append(error)
        u, integral = acceleration_step(law, integral, error, rate, 0.0, False)
        error, rate = error + rate * dt - 0.5 * u * dt * dt, rate - u * dt
    return np.array(errors)


@pytest.mark.parametrize("integral", [True, False])
def test_the_error_follows_its_equation(integral: bool) -> None:
    w, dt = 40.0, 1e-5
    t = dt * np.arange(30_000)
    law = acceleration_params(w, dt, integral=integral)
    x = w * t
    exact = 1e-3 * np.exp(-x) * ((1.0 + x - x * x) if integral else (1.0 + x))
    np.testing.assert_allclose(ideal_error(law, dt, len(t)), exact, atol=2e-6)


def test_gains_are_the_coefficients_of_the_triple_pole() -> None:
    law = acceleration_params(30.0, 1e-3)
    wanted = np.poly([-30.0] * 3)
    np.testing.assert_allclose([1.0, law.speed_gain, law.position_gain, law.integral_gain / 1e-3], wanted)


def test_an_exact_model_tracks_within_a_few_counts() -> None:
    axis, _ = puma_axis(1)
    error = track(axis, acceleration_params(40.0, 1e-3), wave(2.0))
    count = axis.encoder.resolution / abs(axis.gear.ratio)
    assert abs(error).max() < 5.0 * count
    assert abs(error[-200:]).max() < 2.0 * count


@pytest.mark.parametrize("model", [0.7, 1.3])
def test_a_wrong_model_tracks_worse_but_ends_without_error(model: float) -> None:
    axis, _ = puma_axis(1)
    law = acceleration_params(40.0, 1e-3)
    error, exact = track(axis, law, wave(2.0), model=model), track(axis, law, wave(2.0))
    assert abs(exact).max() < abs(error).max() < 20e-3
    assert abs(error[-100:]).max() < 3e-4


def test_the_integral_is_what_removes_the_error_of_a_constant_load() -> None:
    axis, _ = puma_axis(1, friction=False)  # which would hold a part of the load
    rest = np.zeros(1500), np.zeros(1500), np.zeros(1500)
    with_it = track(axis, acceleration_params(40.0, 1e-3), rest, model=0.7)
    without = track(axis, acceleration_params(40.0, 1e-3, integral=False), rest, model=0.7)
    assert abs(with_it[-200:]).max() < 2e-4
    assert abs(without[-200:]).min() > 3e-4


def test_a_clipped_current_does_not_wind_the_integral_up() -> None:
    """A step of 0.5 rad clips the current; the axis then passes the end by less than a free one's 27 %."""
    axis, _ = puma_axis(1)
    step = np.r_[0.0, np.full(1999, 0.5)], np.zeros(2000), np.zeros(2000)
    error = track(axis, acceleration_params(15.0, 1e-3), step)
    assert abs(error[-200:]).max() < 3e-3
    assert error.min() > -0.1 * 0.5


def test_torque_to_current_has_the_sign_of_the_gear_and_says_when_it_clips() -> None:
    assert torque_to_current(10.0, -62.61 * 0.189, 8.25) == (pytest.approx(-10.0 / 62.61 / 0.189), False)
    assert torque_to_current(-500.0, -62.61 * 0.189, 8.25) == (8.25, True)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((0.0, 1e-3), "bandwidth is 0"),
        ((40.0, math.nan), "dt is nan"),
        ((200.0, 1e-3), "at most 100 rad/s there, or sample faster"),
    ],
)
def test_bad_numbers_are_named(arguments: tuple[float, float], named: str) -> None:
    with pytest.raises(OutOfLimits, match=named):
        acceleration_params(*arguments)
    with pytest.raises(OutOfLimits, match="max_correction is -1"):
        acceleration_params(40.0, 1e-3, max_correction=-1.0)


def test_more_bandwidth_means_less_error() -> None:
    axis, _ = puma_axis(1)
    errors = [abs(track(axis, acceleration_params(w, 1e-3), wave(2.0), model=0.8)).max() for w in (15, 30, 60)]
    assert all(later < 0.7 * earlier for earlier, later in pairwise(errors))


@pytest.mark.parametrize("seed", range(10))
def test_an_inertia_below_the_least_is_unstable(seed: int) -> None:
    """By the roots of the error equation, of any gains; a triple pole bears a ninth."""
    rng, dt = np.random.default_rng(seed), 1e-3
    kp, kv, ki = rng.uniform(1.0, 100.0, 3)
    least = least_inertia(AccelerationParams(kp, kv, ki * dt, math.inf), dt)
    for part, stable in ((1.001 * least, True), (0.999 * least, False)):
        assert (np.roots([1.0, part * kv, part * kp, part * ki]).real.max() < 0.0) == stable
    assert least_inertia(acceleration_params(rng.uniform(1.0, 90.0), dt), dt) == pytest.approx(1.0 / 9.0)
