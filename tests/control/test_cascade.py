"""One closed axis with real drives: tracking, limits, load, encoder, wrong inertia."""

from __future__ import annotations

import math

import numpy as np
import pytest
from one_axis import COUNTS, INERTIA, RATIO, SPEED, TORQUE, VISCOUS, puma_axis, simulate, trapezoid

from holonom.control import PositionParams, position_step, speed_step

axes = pytest.mark.parametrize("number", range(1, 7))
COUNT = tuple(2.0 * math.pi / n / abs(ratio) for n, ratio in zip(COUNTS, RATIO, strict=True))


def hold(value: float, samples: int) -> tuple[np.ndarray, np.ndarray]:
    return np.r_[0.0, np.full(samples - 1, value)], np.zeros(samples)


@axes
@pytest.mark.parametrize("distance", [0.01, -1.0])
def test_a_step_arrives_without_overshoot_and_within_the_limits(number: int, distance: float) -> None:
    axis, gains = puma_axis(number)
    run = simulate(axis, *hold(distance, 2500))
    past = (run.q - distance) * math.copysign(1.0, distance)
    assert past.max() < 2.0 * COUNT[number - 1]
    assert abs(run.q[-5000:] - distance).max() < 2.0 * COUNT[number - 1]
    assert abs(run.current).max() < 1.02 * gains.speed.max_current
    assert abs(run.current_reference).max() <= gains.speed.max_current
    assert abs(run.voltage).max() <= 40.0
    assert abs(run.qd).max() < 1.05 * SPEED[number - 1]


@axes
def test_a_constant_load_leaves_no_error(number: int) -> None:
    axis, _ = puma_axis(number)
    load = np.zeros(3000)
    load[500:] = 0.3 * TORQUE[number - 1]
    run = simulate(axis, np.zeros(3000), np.zeros(3000), load=load)
    assert run.q.min() < -COUNT[number - 1]  # the load is felt
    assert run.q.min() > -2e-3
    assert abs(run.q[-5000:].mean()) < 0.5 * COUNT[number - 1]
    held = run.current[-5000:].mean() * 0.5 * (axis.gear.ratio * axis.torque_constant)
    assert abs(2.0 * held - 0.3 * TORQUE[number - 1]) < abs(RATIO[number - 1]) * axis.friction.coulomb_negative


@axes
def test_a_trapezoid_is_tracked_better_with_acceleration_fed_forward(number: int) -> None:
    axis, _ = puma_axis(number)
    rate = 0.3 * TORQUE[number - 1] / INERTIA[number - 1]
    q, qd, qdd = trapezoid(2.0, 0.8 * SPEED[number - 1], rate, rest=0.5)
    plain = q - simulate(axis, q, qd).q[::10]
    ahead = q - simulate(axis, q, qd, qdd_ref=qdd).q[::10]
    assert abs(plain).max() < 3e-3
    assert abs(ahead).max() < 0.8 * abs(plain).max()
    assert abs(plain[-200:]).max() < 2.0 * COUNT[number - 1]


@pytest.mark.parametrize("factor", [0.4, 2.5])
def test_a_wrong_inertia_stays_stable(factor: float) -> None:
    axis, _ = puma_axis(1)
    wrong = axis._replace(inertia=factor * axis.inertia)
    run = simulate(wrong, *hold(0.1, 3000))
    assert abs(run.q[-5000:] - 0.1).max() < 3.0 * COUNT[0]


def test_without_friction_the_speed_step_has_the_designed_overshoot() -> None:
    """PI with T_i = 10 T_V': the open zero gives a step of the symmetrical optimum, more than 10 %, below 45 %."""
    axis, gains = puma_axis(3, friction=False, counts=100_000)
    speed = np.full(400, 0.05)
    run = simulate(axis, np.zeros(400), speed, inner=True)
    peak = run.qd.max() / 0.05
    assert 1.1 < peak < 1.45
    rise = np.flatnonzero(run.qd > 0.05)[0] * 1e-4
    assert rise == pytest.approx(1.6 / gains.speed_margin.crossover, rel=0.4)
    assert run.qd[-500:].mean() == pytest.approx(0.05, rel=1e-3)


def test_saturated_current_does_not_wind_the_speed_loop_up() -> None:
    """A speed step that keeps the current clipped for 38 ms ends without overshoot."""
    axis, gains = puma_axis(1, friction=False, counts=100_000)
    wanted = 0.9 * SPEED[0]
    run = simulate(axis, np.zeros(400), np.full(400, wanted), inner=True)
    assert (run.current_reference == -gains.speed.max_current).sum() > 300  # joint 1 turns against its motor
    assert run.qd.max() < 1.02 * wanted
    assert run.qd[-500:].mean() == pytest.approx(wanted, rel=2e-3)


@pytest.mark.parametrize("delay", [0, 1])
def test_one_wrong_speed_reading_costs_no_more_than_its_sample(delay: int) -> None:
    """Of the Puma's waist (3.5 kg m2): 40 rad/s off once; then a step to 80 rad/s. Trial of `open_cases.json`."""
    axis, gains = puma_axis(1)
    per_ampere = gains.times.speed * axis.torque_constant / axis.assumed_inertia

    def speeds(reference: float, off: float) -> np.ndarray:
        speed, integral, seen = 0.0, 0.0, []
        waiting = [0.0] * delay
        for k in range(4000):
            current, integral = speed_step(gains.speed, integral, reference, speed + off * (k == 10), 0.0)
            waiting.append(current)
            speed += per_ampere * waiting.pop(0)
            seen.append(speed)
        return np.array(seen)

    spike = speeds(0.0, -40.0)
    assert spike.max() == pytest.approx(per_ampere * gains.speed.max_current)  # one sample of full current: 0.87 rad/s
    assert spike.min() > -0.3
    assert speeds(80.0, 0.0).max() < 1.02 * 80.0


def test_saturated_voltage_does_not_wind_the_speed_loop_up() -> None:
    """Far above the speed that the supply allows, for a second; then back to a slow speed without delay."""
    axis, _ = puma_axis(4)
    top = 40.0 / axis.torque_constant / abs(axis.gear.ratio)
    speed = np.r_[np.full(1000, 2.0 * top), np.full(500, 0.3 * top)]
    run = simulate(axis, np.zeros(1500), speed, inner=True)
    assert abs(run.voltage).max() == 40.0
    assert 0.85 * top < run.qd[9999] < top
    assert run.qd[10_050:].max() < run.qd[9999]  # braking starts at once
    assert run.qd[11_500:].max() < 0.36 * top
    assert run.qd[10_000:].min() > 0.27 * top


def test_rated_speed_is_within_the_supply_but_not_with_full_torque_on_the_wrist() -> None:
    """Specification 03.1 at the rated joint speeds: back-emf and viscous friction alone need less than 25 V."""
    full = []
    for number in range(1, 7):
        axis, gains = puma_axis(number)
        speed = SPEED[number - 1] * abs(RATIO[number - 1])
        free = (
            axis.torque_constant * speed
            + VISCOUS[number - 1] * speed / axis.torque_constant / axis.armature.conductance
        )
        assert free < 25.0
        full.append(axis.torque_constant * speed + gains.speed.max_current / axis.armature.conductance)
    assert [voltage <= 40.5 for voltage in full] == [True] * 3 + [False] * 3


def test_the_position_law_is_linear_then_a_braking_curve() -> None:
    params = PositionParams(gain=20.0, max_speed=1e9, max_braking=300.0)
    corner = 300.0 / 20.0**2
    assert position_step(params, 0.5 * corner, 0.0, 0.0) == pytest.approx(20.0 * 0.5 * corner)
    assert position_step(params, 0.0, 7.0, 0.1) == pytest.approx(7.0 - 2.0)
    h = 1e-7
    below, above = (position_step(params, corner + d, 0.0, 0.0) for d in (-h, h))
    assert above - below == pytest.approx(20.0 * 2.0 * h, rel=1e-3)  # continuous in value and slope
    far, step = 50.0, 1e-4
    slope = (position_step(params, far + step, 0.0, 0.0) - position_step(params, far - step, 0.0, 0.0)) / (2 * step)
    assert slope * position_step(params, far, 0.0, 0.0) == pytest.approx(300.0, rel=1e-6)  # v dv/dx is the braking
    assert position_step(params._replace(max_speed=5.0), -far, 0.0, 0.0) == -5.0
