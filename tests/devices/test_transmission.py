"""Friction and gear."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from itertools import repeat
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from holonom.devices import (
    Friction,
    Gear,
    LuGre,
    friction_torque,
    gear_torque,
    geared_step,
    lugre_step,
    stiction_step,
)
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


STICKY = Friction(0.0, 0.4, 0.3, static_ratio=1.5, stribeck_speed=2.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_breakaway_is_the_static_friction(side: float) -> None:
    coulomb = 0.4 if side > 0.0 else 0.3
    angles, _ = turn(STICKY, repeat(1.49 * side * coulomb, 60_000))
    assert max(angles[20_000:]) - min(angles[20_000:]) < 1e-12
    _, speeds = turn(STICKY, repeat(1.51 * side * coulomb, 20_000))
    assert side * speeds[-1] > 100.0  # once it slips, half of the static friction is left to drive it


@given(speed=speeds.filter(lambda w: abs(w) > 1e-3), ratio=st.floats(1.0, 3.0), width=st.floats(0.1, 100.0))
def test_friction_falls_by_stribecks_curve(speed: float, ratio: float, width: float) -> None:
    friction = Friction(1e-3, 0.4, 0.3, ratio, width)
    coulomb = math.copysign(0.4 if speed > 0.0 else 0.3, speed)
    expected = 1e-3 * speed + coulomb * (1.0 + (ratio - 1.0) * width**2 / (width**2 + speed**2))
    params, held, rubbed = friction.stiction(INERTIA, DT), 0.0, 0.0
    for _ in range(2 + math.ceil(3.0 / (params.winding * abs(speed)))) if abs(speed) > 0.1 else ():
        rubbed, held = stiction_step(params, held, speed)
    if abs(speed) > 0.1:
        assert rubbed == pytest.approx(expected, rel=1e-12)
    assert friction_torque(friction.params(1e-9), speed) == pytest.approx(expected, rel=1e-9)


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


efficiencies = st.floats(0.3, 0.99)


def test_published_gear(data_folder: Path) -> None:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    found = next(one for one in cases if one["id"] == "gear with efficiency")
    g, wanted = found["input"], found["expected"]
    gear, m = Gear(g["ratio"], g["efficiency"]), g["motor_torque"]
    assert gear_torque(gear.params(), m, 1.0) == pytest.approx(wanted["driving"], rel=found["tol"])
    assert gear_torque(gear.params(), m, -1.0) == pytest.approx(wanted["driven_back"], rel=found["tol"])
    params = Friction().stiction(INERTIA, DT, gear.efficiency)
    for speed, name in ((100.0, "driving"), (-100.0, "driven_back")):
        assert geared_step(params, gear.params(), 0.0, m, speed)[0] == pytest.approx(wanted[name], rel=found["tol"])


@given(efficiency=efficiencies, torque=st.floats(-2.0, 2.0), speed=st.sampled_from([-400.0, -90.0, 90.0, 400.0]))
def test_a_turning_gear_with_friction_is_both_in_turn(efficiency: float, torque: float, speed: float) -> None:
    gear, params = Gear(-62.61, efficiency).params(), STICKY.stiction(INERTIA, DT, efficiency)
    held = found = rubbed = other = 0.0
    for _ in range(20):
        found, held = geared_step(params, gear, held, torque, speed)
        rubbed, other = stiction_step(params, other, speed)
    assert found == pytest.approx(gear_torque(gear, torque - rubbed, speed), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("coulomb", [0.0, 0.1])
@pytest.mark.parametrize("efficiency", [0.4, 0.8, 0.97])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_gear_at_rest_holds_whatever_it_can(side: float, efficiency: float, coulomb: float) -> None:
    """Between what drives it and what drives it back it stands; beyond either it turns that way."""
    motor = 0.5 * side
    least = efficiency * (0.5 - coulomb) * side
    most = (0.5 + coulomb) / efficiency * side
    for part, way in ((-0.02, 1.0), (0.02, 0.0), (0.5, 0.0), (0.98, 0.0), (1.02, -1.0)):
        load = least + part * (most - least)
        gear, params = Gear(1.0, efficiency).params(), Friction(0.0, coulomb, coulomb).stiction(INERTIA, DT, efficiency)
        held = speed = angle = 0.0
        places = []
        for k in range(20_000):
            torque, held = geared_step(params, gear, held, motor, speed)
            speed += DT * (torque - load) / INERTIA
            angle += DT * speed
            if k >= 10_000:
                places.append(angle)
        if way == 0.0:
            assert max(places) - min(places) < 1e-12
            assert abs(speed) < 1e-12
        else:
            assert side * way * (places[-1] - places[0]) > 0.1


@given(st.lists(st.tuples(speeds, st.floats(-2.0, 2.0)), max_size=100), efficiencies)
def test_a_slipping_shaft_and_its_gear_take_power(history: list[tuple[float, float]], efficiency: float) -> None:
    gear, params, held = Gear(1.0, efficiency).params(), STICKY.stiction(INERTIA, DT, efficiency), 0.0
    for speed, motor in history:
        torque, held = geared_step(params, gear, held, motor, speed)
        if abs(speed) > 50.0:
            assert (motor - torque) * speed >= -1e-9


@given(st.floats(0.0, 0.95))
def test_a_gear_of_load_friction(part: float) -> None:
    """Driving and driven back differ from their mean by that part of it, whatever the torque."""
    gear = Gear.rubbing(50.0, part)
    driving, back = (gear_torque(gear.params(), 1.0, speed) for speed in (1.0, -1.0))
    assert (back - driving) / (back + driving) == pytest.approx(part, abs=1e-12)
    assert gear.load_friction == pytest.approx(part, abs=1e-12)


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
        (lambda: Friction(0.0, 0.1, 0.1, 0.9), "static_ratio is 0.9; it must be finite and at least 1"),
        (lambda: Friction(0.0, 0.1, 0.1, 1.5), "static_ratio is 1.5, stribeck_speed 0; state the speed"),
        (lambda: Friction(0.0, 0.1, 0.1).stiction(1e-4, 1e-4, 0.0), "efficiency is 0"),
        (lambda: Gear.rubbing(10.0, -0.1), "load_friction is -0.1"),
        (lambda: Gear.rubbing(10.0, 1.0), "load_friction is 1; it must be less than 1"),
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
