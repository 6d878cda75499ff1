"""Harmonic drive, backlash, dead zone, two masses."""

from __future__ import annotations

import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from holonom.devices import (
    Backlash,
    DeadZone,
    HarmonicDrive,
    TwoMass,
    TwoMassState,
    dead_zone,
    flank_torque,
    harmonic_torques,
    play_step,
    two_mass_step,
    undo_dead_zone,
)
from holonom.errors import ModelError


def case(folder: Path, start: str) -> tuple[dict[str, Any], dict[str, Any], float]:
    cases = json.loads((folder / "control" / "open_cases.json").read_text("utf-8"))
    found = next(one for one in cases if one["id"].startswith(start))
    return found["input"], found["expected"], found["tol"]


DRIVE = HarmonicDrive(202, 200, 1.3e4, 1.8e4, 2.3e4, 14.0, 48.0, ripple=1e-4, phase=0.3)  # figures of a size 25


def test_published_ratio(data_folder: Path) -> None:
    g, wanted, tol = case(data_folder, "harmonic drive")
    drive = HarmonicDrive(g["z1"], g["z2"], 1e4, 1e4, 1e4, 10.0, 20.0)
    assert drive.ratio == pytest.approx(wanted["ratio"], rel=tol)
    assert drive.gear(0.8).ratio == drive.ratio
    assert HarmonicDrive(g["z1"], g["z2"], 1e4, 1e4, 1e4, 10.0, 20.0, reverses=True).ratio == -drive.ratio


@given(st.floats(-200.0, 200.0))
def test_twist_and_torque_are_inverse(torque: float) -> None:
    params = DRIVE.params()._replace(ripple=0.0)
    found = harmonic_torques(params, 0.0, 0.0, -DRIVE.twist(torque), 0.0)
    assert found.joint == pytest.approx(torque, rel=1e-12, abs=1e-12)
    assert found.motor == pytest.approx(torque / DRIVE.ratio, rel=1e-12, abs=1e-12)


def test_stiffness_by_pieces() -> None:
    for torque, stiffness in ((5.0, 1.3e4), (30.0, 1.8e4), (100.0, 2.3e4)):
        for sign in (-1.0, 1.0):
            slope = (DRIVE.twist(sign * torque + 0.01) - DRIVE.twist(sign * torque - 0.01)) / 0.02
            assert 1.0 / slope == pytest.approx(stiffness, rel=1e-6)


@given(motor=st.floats(-100.0, 100.0), joint=st.floats(-3e-3, 3e-3))
def test_a_harmonic_drives_torques_are_slopes_of_its_energy(motor: float, joint: float) -> None:
    """Both torques come from one stored energy: the error and the stiffness give and take nothing."""
    p = DRIVE.params()
    angle = motor / DRIVE.ratio - joint
    corners = sorted({s * t for s in (-1.0, 1.0) for t in (p.twist_1, p.twist_2)})

    def energy(at: float, to: float) -> float:
        twist = at / p.ratio + p.ripple * math.sin(2.0 * at + p.phase) - to
        inside = [c for c in corners if min(0.0, twist) < c < max(0.0, twist)]
        ends = [0.0, *sorted(inside, key=abs), twist]
        return sum(quad(lambda x: _torque(x), a, b, epsabs=1e-13)[0] for a, b in itertools.pairwise(ends))

    def _torque(x: float) -> float:
        size, torque = abs(x), 0.0
        for low, high, k in (
            (0.0, p.twist_1, DRIVE.stiffness_1),
            (p.twist_1, p.twist_2, DRIVE.stiffness_2),
            (p.twist_2, math.inf, DRIVE.stiffness_3),
        ):
            torque += k * min(max(size - low, 0.0), high - low)
        return math.copysign(torque, x)

    found, d = harmonic_torques(p, motor, 0.0, angle, 0.0), 1e-6
    at_motor = (energy(motor + d, angle) - energy(motor - d, angle)) / (2.0 * d)
    at_joint = -(energy(motor, angle + d) - energy(motor, angle - d)) / (2.0 * d)
    assert found.motor == pytest.approx(at_motor, abs=2e-5 + 1e-5 * abs(at_motor))
    assert found.joint == pytest.approx(at_joint, abs=2e-2 + 1e-5 * abs(at_joint))


@given(motor=st.floats(-50.0, 50.0), speed=st.floats(-300.0, 300.0), joint_speed=st.floats(-5.0, 5.0))
def test_damping_only_takes_power(motor: float, speed: float, joint_speed: float) -> None:
    params = DRIVE.params()
    joint = motor / params.ratio + 1e-4
    without = harmonic_torques(params, motor, speed, joint, joint_speed)
    found = harmonic_torques(params._replace(damping=7.0), motor, speed, joint, joint_speed)
    lost = (found.motor - without.motor) * speed - (found.joint - without.joint) * joint_speed
    assert lost >= -1e-9


def test_ripple_is_twice_a_turn_of_the_wave_generator() -> None:
    """Where the joint comes to rest without load, over a turn of the motor: one harmonic, the second."""
    params, turn = DRIVE.params(), np.linspace(0.0, math.tau, 64, endpoint=False)
    rest = []
    for motor in turn:
        joint = motor / params.ratio
        for _ in range(60):
            joint += harmonic_torques(params, motor, 0.0, joint, 0.0).joint / params.stiffness_3
        rest.append(joint - motor / params.ratio)
    harmonics = 2.0 * np.abs(np.fft.rfft(rest)) / len(turn)
    assert harmonics[2] == pytest.approx(DRIVE.ripple, rel=1e-6)
    assert np.delete(harmonics, 2).max() < 1e-9
    assert DRIVE.speed_ripple == pytest.approx(2.0 * 1e-4 * 100.0)


def test_published_describing_function(data_folder: Path) -> None:
    g, wanted, tol = case(data_folder, "describing function of play")
    found = Backlash(2.0 * g["half_gap"]).describing_function(g["amplitude"])
    assert (found.real, found.imag) == pytest.approx((wanted["real"], wanted["imaginary"]), rel=tol)


@pytest.mark.parametrize("part", [0.02, 0.3, 0.5, 0.8, 0.98, 1.0, 1.5])
def test_describing_function_is_the_first_harmonic_of_play(part: float) -> None:
    n, gap, amplitude = 4096, 0.3, 0.15 / part
    sine, out, outputs = amplitude * np.sin(math.tau * np.arange(3 * n) / n), 0.0, []
    for given_ in sine.tolist():
        out = play_step(0.5 * gap, out, given_)
        outputs.append(out)
    first = 2j * np.exp(-1j * math.tau * np.arange(n) / n) @ outputs[-n:] / n / amplitude
    assert Backlash(gap).describing_function(amplitude) == pytest.approx(first, abs=2e-3)


@given(st.lists(st.floats(-10.0, 10.0), max_size=50), st.floats(0.0, 3.0))
def test_play_keeps_within_its_gap_and_moves_only_at_its_ends(course: list[float], half: float) -> None:
    out = 0.0
    for given_ in course:
        after = play_step(half, out, given_)
        assert abs(after - given_) <= half + 1e-12
        assert after == out or abs(abs(after - given_) - half) < 1e-12
        assert play_step(half, after, given_) == after
        out = after


@given(twist=st.floats(-1.0, 1.0), rate=st.floats(-5.0, 5.0))
def test_flanks_push_and_never_pull(twist: float, rate: float) -> None:
    gap = Backlash(0.4, 100.0, 3.0)
    torque = flank_torque(gap.params(), twist, rate)
    assert torque * twist >= 0.0
    if abs(twist) <= 0.2:
        assert torque == 0.0
    still = flank_torque(gap.params(), twist, 0.0)
    assert still == pytest.approx(math.copysign(100.0 * max(abs(twist) - 0.2, 0.0), twist), abs=1e-12)
    assert flank_torque(gap.params(), -twist, -rate) == pytest.approx(-torque)


def test_a_load_floats_through_the_gap_and_keeps_its_momentum() -> None:
    """Two free inertias, the driving one kicked: nothing but flank forces between them; energy as damping allows."""
    J, L, dt, params = 1e-3, 2e-3, 1e-6, Backlash(0.1, 500.0).params()
    angle, speed, load, load_speed, floated = 0.0, 10.0, 0.0, 0.0, 0
    for _ in range(100_000):
        torque = flank_torque(params, angle - load, speed - load_speed)
        floated += torque == 0.0
        speed, load_speed = speed - dt * torque / J, load_speed + dt * torque / L
        angle, load = angle + dt * speed, load + dt * load_speed
    assert J * speed + L * load_speed == pytest.approx(1e-2, rel=1e-9)
    stored = 0.5 * 500.0 * max(abs(angle - load) - 0.05, 0.0) ** 2
    assert 0.5 * (J * speed**2 + L * load_speed**2) + stored == pytest.approx(0.05, rel=1e-4)
    assert floated > 10_000


@given(st.floats(0.0, 60.0))
def test_a_preloaded_pair_has_no_gap_and_twice_the_stiffness(torque: float) -> None:
    pair, loose = Backlash(stiffness=200.0, preload=10.0, rubbing=0.05), Backlash(0.02, 200.0)
    assert flank_torque(pair.params(), 1e-6, 0.0) == pytest.approx(2.0 * 200.0 * 1e-6)
    assert flank_torque(loose.params(), 1e-6, 0.0) == 0.0
    assert (pair.coulomb, loose.coulomb) == (pytest.approx(1.0), 0.0)
    for one in (pair, loose):
        half = 0.5 * one.lost(torque)
        assert flank_torque(one.params(), half, 0.0) == pytest.approx(torque, abs=1e-9)
        assert flank_torque(one.params(), -half, 0.0) == pytest.approx(-torque, abs=1e-9)
    assert pair.lost(0.0) == 0.0
    assert loose.lost(0.0) == 0.02


@given(st.floats(-50.0, 50.0), st.floats(0.0, 5.0), st.floats(0.0, 5.0))
def test_a_dead_zone_behind_its_inverse_is_nothing(wanted: float, positive: float, negative: float) -> None:
    params = DeadZone(positive, negative).params()
    assert dead_zone(params, undo_dead_zone(params, wanted)) == pytest.approx(wanted, abs=1e-12)
    inside = positive * 0.9 if wanted > 0.0 else -negative * 0.9
    assert dead_zone(params, inside) == 0.0


@given(
    wanted=st.floats(-20.0, 20.0),
    gain=st.floats(0.1, 50.0),
    tachometer=st.floats(0.0, 5.0),
)
def test_what_a_tachometer_loop_leaves_of_a_dead_zone(wanted: float, gain: float, tachometer: float) -> None:
    """The loop solved by bisection, against an open motor with the smaller zone."""
    zone, loop = DeadZone(2.0, 1.0), 1.0 + gain * tachometer
    low, high = -gain * 1e3, gain * 1e3
    for _ in range(200):
        speed = 0.5 * (low + high)
        if gain * dead_zone(zone.params(), loop * wanted - tachometer * speed) > speed:
            low = speed
        else:
            high = speed
    left = zone.behind_tachometer(gain, tachometer)
    assert left.positive == pytest.approx(2.0 / loop)
    assert gain * dead_zone(left.params(), wanted) == pytest.approx(0.5 * (low + high), rel=1e-6, abs=1e-6)


def test_published_two_masses(data_folder: Path) -> None:
    g, wanted, tol = case(data_folder, "two-mass")
    found = TwoMass(g["J_motor"], g["J_load"], g["stiffness"])
    assert found.resonance_Hz == pytest.approx(wanted["resonance_Hz"], rel=tol)
    assert found.antiresonance_Hz == pytest.approx(wanted["antiresonance_Hz"], rel=tol)


positive = st.floats(1e-5, 1e-2)


@given(J=positive, L=positive, stiffness=st.floats(1.0, 1e4), part=st.floats(0.0, 0.5))
def test_resonances_are_poles_and_zeros(J: float, L: float, stiffness: float, part: float) -> None:
    plain = TwoMass(J, L, stiffness)
    assert np.abs(np.linalg.eigvals(plain.state_matrices()[0]).imag).max() == pytest.approx(plain.resonance, rel=1e-9)
    assert np.abs(np.roots(plain.motor_response[0])).max() == pytest.approx(plain.antiresonance, rel=1e-9)
    damped = TwoMass(J, L, stiffness, part * math.sqrt(stiffness * J * L / (J + L)))
    A, B = damped.state_matrices()
    s = 1j * 0.7 * damped.resonance + 0.2 * damped.resonance
    direct = np.linalg.solve(s * np.eye(3) - A, B[:, 0])
    for (num, den), state in ((damped.motor_response, direct[1]), (damped.load_response, direct[2])):
        assert np.polyval(num, s) / np.polyval(den, s) == pytest.approx(state, rel=1e-9)


@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_a_step_of_two_masses_is_exact(damping: float) -> None:
    masses, dt = TwoMass(1.37e-5, 3e-5, 20.0, damping), 5e-4
    state, params = TwoMassState(1e-3, 5.0, -3.0), masses.params(dt)
    A, B = masses.state_matrices()
    exact = solve_ivp(
        lambda _, x: A @ x + B @ [0.02, 0.01], (0.0, 20 * dt), list(state), method="DOP853", rtol=1e-11, atol=1e-12
    ).y[:, -1]
    for _ in range(20):
        state = two_mass_step(params, state, 0.02, 0.01)
    np.testing.assert_allclose(state, exact, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (lambda: HarmonicDrive(200, 202, 1e4, 1e4, 1e4, 10.0, 20.0), "200 circular and 202 flex teeth"),
        (lambda: HarmonicDrive(202, 200, 1e4, 1e4, 1e4, 20.0, 10.0), "torque_2 is 10"),
        (lambda: HarmonicDrive(202, 200, 0.0, 1e4, 1e4, 10.0, 20.0), "stiffness_1 is 0"),
        (lambda: DRIVE.twist(math.nan), "torque is nan"),
        (lambda: Backlash(-0.1), "gap is -0.1"),
        (lambda: Backlash(0.1, preload=3.0), "gap is 0.1 and preload 3; a pair pressed together"),
        (lambda: Backlash(0.1).describing_function(0.0), "amplitude is 0"),
        (lambda: Backlash(0.1).lost(-1.0), "torque is -1"),
        (lambda: DeadZone(-1.0), "positive is -1"),
        (lambda: DeadZone(1.0, 1.0).behind_tachometer(-1.0, 1.0), "speed_gain is -1"),
        (lambda: DeadZone(1.0, 1.0).behind_tachometer(1.0, math.inf), "tachometer_gain is inf"),
        (lambda: TwoMass(0.0, 1.0, 1.0), "motor_inertia is 0"),
        (lambda: TwoMass(1.0, 1.0, 1.0).params(0.0), "dt is 0"),
    ],
)
def test_bad_numbers_are_named(make: object, named: str) -> None:
    with pytest.raises(ModelError, match=named):
        make()  # type: ignore[operator]
