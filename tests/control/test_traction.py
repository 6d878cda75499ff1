"""Traction control, the watch over the motors, the wheel's speed loop."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete

from holonom.control import ServoAxis
from holonom.control.base.kernels import (
    BLIND,
    JAMMED,
    OPEN,
    WORKS,
    Suspicion,
    traction_step,
    watch_step,
    watch_verdict,
    within_slip,
)
from holonom.control.base.traction import TractionSettings, WatchSettings
from holonom.control.base.tuning import tune_wheel
from holonom.errors import OutOfLimits

TRACTION = TractionSettings()
PARAMS = TRACTION.params(1e-3)
WATCH = WatchSettings().params(1e-3)
AXIS = ServoAxis(1.2, 0.56e-3, 25.5e-3, 25.5e-3, 2.7e-4, 14.8, 8.0, 580.0, 4096)
SPINNING = 1.2e-5


@given(st.floats(0.0, 1.0), st.floats(-1.0, 1.0), st.floats(-5.0, 5.0))
def test_force_is_cut_only_where_it_makes_slip(cut: float, slip: float, force: float) -> None:
    after = traction_step(PARAMS, cut, slip, force)
    assert 0.0 <= after <= 1.0
    makes = (slip if force >= 0.0 else -slip) > TRACTION.free_slip
    assert after <= cut if makes else after >= cut


def test_times_of_cut_and_recovery() -> None:
    cut = 1.0
    for _ in range(20):
        cut = traction_step(PARAMS, cut, 1.0, 1.0)
    assert cut == pytest.approx(0.0, abs=1e-12)
    for _ in range(100):
        cut = traction_step(PARAMS, cut, 0.0, 1.0)
    assert cut == pytest.approx(0.5)


@given(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_commanded_slip_is_limited(wanted: float, ground: float) -> None:
    rim = within_slip(PARAMS, wanted, ground)
    assert abs(rim - ground) <= TRACTION.max_slip * (1 + 1e-9)
    if abs(wanted - ground) <= TRACTION.max_slip:
        assert rim == wanted


@pytest.mark.parametrize(
    ("measured", "modelled", "speed", "reference", "grows"),
    [
        (0.0, 1.0, 50.0, 50.0, "open"),  # no current where there must be some
        (0.0, 1.0, 0.0, 50.0, "open"),  # so, too, at standstill: it is not jammed
        (0.9, 1.0, 50.0, 50.0, ""),
        (5.0, 5.0, 0.0, 50.0, "jam"),  # current, but it stands
        (5.0, 5.0, 0.0, 0.0, ""),  # as it is told to
        (0.0, 0.1, 50.0, 50.0, ""),  # proves nothing
        (5.0, 5.0, 2.0, 50.0, ""),  # slow, but it turns
    ],
)
def test_evidence_against_a_motor(measured: float, modelled: float, speed: float, reference: float, grows: str) -> None:
    before = Suspicion(0.01, 0.01, 0.0)
    after = watch_step(WATCH, before, measured, modelled, speed, reference)
    assert {name for name in before._fields if getattr(after, name) > 0.01} == ({grows} if grows else set())


def test_evidence_for_a_motor_takes_it_back() -> None:
    before = Suspicion(0.01, 0.01, 0.0)
    assert watch_step(WATCH, before, 1.0, 1.0, 50.0, 50.0) == pytest.approx((0.009, 0.0, 0.0))
    assert watch_step(WATCH, before, 0.0, 0.0, 50.0, 50.0) == before


def test_a_motor_that_turns_and_is_not_counted() -> None:
    """It stands by its encoder, and its back-emf leaves less current: neither a jam nor an open winding."""
    seen, samples = Suspicion(0.0, 0.0, 0.0), 0
    while watch_verdict(WATCH, seen) == WORKS:
        seen = watch_step(WATCH, seen, 2.0, 8.0, 0.0, 50.0, False, 240.0)
        samples += 1
    assert watch_verdict(WATCH, seen) == BLIND
    assert samples == pytest.approx(40, abs=1)


@pytest.mark.parametrize(("current", "explained", "verdict", "time"), [
    (0.0, False, OPEN, 0.03), (0.0, True, OPEN, 0.03), (5.0, False, JAMMED, 0.04), (5.0, True, JAMMED, 0.16),
    (1.5, False, JAMMED, 0.16),
])  # fmt: skip
def test_verdict_on_a_motor_that_stands(current: float, explained: bool, verdict: int, time: float) -> None:
    """Current tells an open winding from a jam; that takes longer where slip or little force may explain it."""
    seen, samples = Suspicion(0.0, 0.0, 0.0), 0
    while watch_verdict(WATCH, seen) == WORKS:
        seen = watch_step(WATCH, seen, current, 4.0, 0.0, 50.0, explained)
        samples += 1
    assert watch_verdict(WATCH, seen) == verdict
    assert samples == pytest.approx(1e3 * time, abs=1)


@given(st.floats(1.0, 60.0), st.floats(5e-6, 1e-4))
def test_margins_on_the_floor_and_spinning(ratio: float, spinning: float) -> None:
    axis = ServoAxis(1.2, 0.56e-3, 25.5e-3, 25.5e-3, ratio * spinning, 14.8, 8.0, 580.0, 4096)
    loop = tune_wheel(axis, spinning)
    assert loop.spinning.phase_margin > 0.6
    assert loop.on_floor.phase_margin > 0.6
    assert loop.on_floor.crossover <= loop.spinning.crossover * (1 + 1e-9)


@pytest.mark.parametrize("inertia", [SPINNING, AXIS.inertia])
def test_the_sampled_loop_is_stable_and_follows(inertia: float) -> None:
    """Armature and inertia discretised exactly, observer as it runs, one sample of computing time."""
    loop = tune_wheel(AXIS, SPINNING)
    dt = 1e-3
    A = np.array([[-AXIS.resistance / AXIS.inductance, 0.0], [AXIS.torque_constant / inertia, 0.0]])
    Ad, Bd, *_ = cont2discrete((A, np.array([[1.0 / AXIS.inductance], [0.0]]), np.eye(2), np.zeros((2, 1))), dt)
    r = math.exp(-loop.observer_bandwidth * dt)
    gains = np.array([1.0 - r**3, 1.5 * (1.0 - r) ** 2 * (1.0 + r) / dt, (1.0 - r) ** 3 / dt**2])
    x, angle, seen, integral, u = np.zeros(2), 0.0, np.zeros(3), 0.0, 0.0
    speeds = []
    for _ in range(3000):
        angle += dt * x[1]
        x = Ad @ x + Bd[:, 0] * u
        error = angle - (seen[0] + dt * (seen[1] + 0.5 * dt * seen[2]))
        seen = np.array([angle - error, seen[1] + dt * seen[2], seen[2]]) + gains * error
        off = 10.0 - seen[1]
        integral += loop.speed.integral_gain * off
        u = AXIS.resistance * (loop.speed.gain * off + integral)
        speeds.append(x[1])
    assert speeds[-1] == pytest.approx(10.0, rel=1e-3)
    assert max(speeds) < 17.0


def test_bad_input() -> None:
    with pytest.raises(OutOfLimits, match="free_slip"):
        TractionSettings(0.2, 0.1)
    with pytest.raises(OutOfLimits, match="cut_time"):
        TractionSettings(cut_time=0.0)
    with pytest.raises(OutOfLimits, match="least_part"):
        WatchSettings(least_part=1.5)
    with pytest.raises(OutOfLimits, match="patience"):
        WatchSettings(patience=0.0)
    with pytest.raises(OutOfLimits, match="doubt"):
        WatchSettings(doubt=2.0)
    with pytest.raises(OutOfLimits, match="spinning_inertia"):
        tune_wheel(AXIS, 1.0)
    with pytest.raises(OutOfLimits, match="phase_margin"):
        tune_wheel(AXIS, SPINNING, phase_margin=2.0)
    with pytest.raises(OutOfLimits, match="dt"):
        tune_wheel(AXIS, SPINNING, dt=0.0)
    with pytest.raises(OutOfLimits, match="no speed loop of this wheel keeps its phase margin at any crossover"):
        tune_wheel(AXIS, AXIS.inertia, phase_margin=1.19)


def test_a_slow_armature_is_tuned_slowly() -> None:
    """Its lag of 0.8 s leaves a crossover below 1 rad/s."""
    loop = tune_wheel(replace(AXIS, inductance=1.0), SPINNING)
    assert loop.limited_by == "phase margin"
    assert loop.spinning.crossover < 1.0
    assert loop.spinning.phase_margin == pytest.approx(0.8, abs=0.2)
