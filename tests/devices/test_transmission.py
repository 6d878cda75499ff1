"""Friction and gear."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import repeat

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from holonom.devices import Friction, Gear, LuGre, friction_torque, gear_torque, lugre_step, stiction_step
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


INERTIA, DT = 9e-4, 1e-4


def turn(
    friction: Friction, torques: Iterable[float], speed: float = 0.0, inertia: float = INERTIA
) -> list[list[float]]:
    """Angles and speeds of a shaft under torques, one each step; its friction knows INERTIA as the least."""
    params, held, angle = friction.stiction(INERTIA, DT), 0.0, 0.0
    angles, speeds = [angle], [speed]
    for torque in torques:
        rubbed, held = stiction_step(params, held, speed)
        speed += DT * (torque - rubbed) / inertia
        angle += DT * speed
        angles.append(angle)
        speeds.append(speed)
    return [angles, speeds]


@pytest.mark.parametrize("inertia", [INERTIA, 7.0 * INERTIA])
@pytest.mark.parametrize("part", [-0.99, -0.3, 0.0, 0.6, 0.99])
def test_below_breakaway_a_shaft_stands(part: float, inertia: float) -> None:
    friction = Friction(0.0, 0.4, 0.3)
    load = part * (0.4 if part > 0.0 else 0.3)
    angles, speeds = turn(friction, repeat(load, 60_000), speed=1.0, inertia=inertia)
    settled = angles[20_000:]
    assert max(settled) - min(settled) < 1e-12
    assert abs(speeds[-1]) < 1e-9


@pytest.mark.parametrize("part", [-1.1, 1.1])
def test_beyond_breakaway_it_turns_as_without_a_spring(part: float) -> None:
    friction = Friction(0.0, 0.4, 0.3)
    load = part * (0.4 if part > 0.0 else 0.3)
    _, speeds = turn(friction, repeat(load, 10_000))
    assert speeds[-1] == pytest.approx(load / 11.0 / INERTIA, rel=0.01)  # a tenth of the friction drives it, for 1 s


def test_coming_to_rest_against_coulomb_friction() -> None:
    """A load that pushes on, a friction that holds it: 0.25 s, 6.25 rad, then rest (closed form)."""
    params, inertia, dt, held, speed, angle = Friction(0.0, 0.05, 0.05).stiction(1e-4, DT), 1e-4, DT, 0.0, 50.0, 0.0
    stopped = None
    for k in range(5000):
        rubbed, held = stiction_step(params, held, speed)
        speed += dt * (0.03 - rubbed) / inertia
        angle += dt * speed
        if stopped is None and speed <= 0.0:
            stopped = k * dt
    assert stopped == pytest.approx(50.0 * 1e-4 / (0.05 - 0.03), rel=0.002)
    assert angle == pytest.approx(0.5 * 50.0 * 0.25, rel=0.002)
    assert abs(speed) < 1e-12


@given(st.lists(speeds, max_size=200))
def test_stiction_never_gives_energy(history: list[float]) -> None:
    params, held, energy = Friction(1e-3, 0.4, 0.3).stiction(INERTIA, DT), 0.0, 0.0
    for speed in history:
        rubbed, held = stiction_step(params, held, speed)
        energy += DT * rubbed * speed
        assert energy >= -1e-9


CANUDAS = LuGre(1e5, 316.228, 0.4, 1.0, 1.5, 1e-3)


def test_stick_slip_of_a_pulled_mass_is_that_of_a_stiff_solver() -> None:
    """1 kg, pulled by 2 N/m at 0.1 m/s for 30 s (Canudas de Wit et al., fig. 6); LSODA on the same equations."""
    p, mass, spring, pull, dt = CANUDAS, 1.0, 2.0, 0.1, 1e-4

    def rates(t: float, state: np.ndarray) -> list[float]:
        x, v, z = state
        g = p.coulomb + (p.static - p.coulomb) * math.exp(-((v / p.stribeck_speed) ** 2))
        bending = v - p.stiffness * abs(v) / g * z
        force = p.stiffness * z + p.damping * bending + p.viscous * v
        return [v, (spring * (pull * t - x) - force) / mass, bending]

    times = np.linspace(0.0, 30.0, 3001)
    exact = solve_ivp(rates, (0.0, 30.0), [0.0] * 3, method="LSODA", rtol=1e-8, atol=1e-11, t_eval=times).y[0]
    params, bristle, speed, place, places = p.params(dt), 0.0, 0.0, 0.0, [0.0]
    for k in range(300_000):
        friction, bristle = lugre_step(params, bristle, speed)
        speed += dt * (spring * (pull * k * dt - place) - friction) / mass
        place += dt * speed
        if k % 100 == 99:
            places.append(place)
    assert np.abs(np.array(places) - exact).max() < 1.2e-4
    assert places[-1] == pytest.approx(2.5451, abs=0.002)
    fast = np.diff(places) > 1e-4
    starts = times[1:][fast & ~np.r_[False, fast[:-1]]]
    np.testing.assert_allclose(starts, [7.46, 13.83, 20.19, 26.55], atol=0.02)


def test_a_load_below_breakaway_does_not_drift_on_bristles() -> None:
    params, bristle, speed, place, after = CANUDAS.params(1e-4), 0.0, 0.0, 0.0, []
    for k in range(200_000):
        friction, bristle = lugre_step(params, bristle, speed)
        speed += 1e-4 * (0.9 - friction)
        place += 1e-4 * speed
        if k > 20_000:
            after.append(place)
    assert max(after) - min(after) < 1e-9


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
        (lambda: LuGre(1e5, 300.0, 0.4, 1.0, 0.9, 1e-3), "static is 0.9; it must be finite and at least 1"),
        (lambda: LuGre(0.0, 300.0, 0.4, 1.0, 1.5, 1e-3), "stiffness is 0"),
        (lambda: CANUDAS.params(0.0), "dt is 0"),
        (lambda: Friction(0.0, 0.1, 0.1).stiction(0.0, 1e-4), "inertia is 0"),
        (lambda: Friction(0.0, 0.1, 0.1).stiction(1e-4, -1.0), "dt is -1"),
    ],
)
def test_bad_numbers_are_named(make: object, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()  # type: ignore[operator]
