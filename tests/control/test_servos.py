"""Designs of servos: published margins of the speed loop, their own loops, notch and elastic shaft, matched limits."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.signal import dlti, dstep, lti, step, tf2zpk

from holonom.control import SERVOS, SampleTimes, ServoAxis, design_cascade
from holonom.control.margins import margin_of
from holonom.control.servo.cascade import design_current, design_speed
from holonom.control.servo.forms.notch import notch_params
from holonom.control.servo.forms.speed_pd import pd_speed_loop, pi_speed_loop
from holonom.control.servo.kernels import position_step, speed_step
from holonom.control.servo.law_design import ServoGains, law_loops, servo_law, servo_loops
from holonom.control.servo.matching import drivable_speed, unmatched
from holonom.errors import ModelError, OutOfLimits

RE40 = ServoAxis(1.13, 0.33e-3, 0.0603, 0.0603, 4.37e-5, 48.0, 10.0, 650.0, 20_000)
WHOLE = dataclasses.replace(RE40, load_inertia=3e-5, stiffness=20.0, gap=0.01, load_counts=8000.0)


@pytest.mark.parametrize(("gain", "margin", "crossover"), [(0.6, 62.1, 2.65), (0.25, 76.3, 1.21)])
def test_the_pd_speed_loop_has_its_published_margins(gain: float, margin: float, crossover: float) -> None:
    for lag in (1e-4, 1e-3, 0.02):
        found = margin_of("speed", pd_speed_loop(lag, gain), 1e-3 * lag)
        assert math.degrees(found.phase_margin) == pytest.approx(margin, abs=0.06)
        assert found.crossover * lag == pytest.approx(crossover, abs=0.006)


def test_the_type_2_speed_loop_overshoots_by_its_published_part_and_by_none_behind_its_prefilter() -> None:
    lag, ti = 1e-3, 1e-2
    w = np.geomspace(1.0, 1e5, 50)
    k = 1.0 / math.sqrt(ti * lag) / ti
    np.testing.assert_allclose(
        pi_speed_loop(lag)(1j * w), k * (1.0 + 1j * w * ti) / ((1j * w) ** 2 * (1.0 + 1j * w * lag)), rtol=1e-12
    )
    closed, behind = [k * ti, k], [k]
    poles = [lag, 1.0, k * ti, k]
    t = np.linspace(0.0, 0.2, 40_001)
    assert 100.0 * (step(lti(closed, poles), T=t)[1].max() - 1.0) == pytest.approx(23.2, abs=0.05)
    assert step(lti(behind, poles), T=t)[1].max() - 1.0 < 1e-4
    assert math.degrees(margin_of("speed", pi_speed_loop(lag), 1e-6).phase_margin) == pytest.approx(54.9, abs=0.05)


@pytest.mark.parametrize("name", list(SERVOS))
def test_a_servo_keeps_its_margins_and_its_loops_say_so(name: str) -> None:
    """Phase margins against a response that is computed anew at the crossover."""
    axis = WHOLE if name in ("notch", "load_side", "backlash") else RE40
    axis = dataclasses.replace(axis, stiffness=math.inf) if name in ("load_side", "backlash") else axis
    for times in (SampleTimes(), SampleTimes(5e-5, 1e-4, 1e-3)):
        gains = SERVOS.make(name).design(axis, times=times)
        assert not gains.warnings
        for loop, margin in gains.margins.items():
            assert math.degrees(margin.phase_margin) > 44.9
            assert margin.gain_margin > 2.0
            at = servo_loops(axis, gains)[loop](np.array([1j * margin.crossover]))[0]
            assert abs(at) == pytest.approx(1.0, rel=1e-3)
            off = math.remainder(np.angle(at) + math.pi - margin.phase_margin, 2.0 * math.pi)
            assert off == pytest.approx(0.0, abs=2e-3)


def test_two_loops_have_the_response_of_their_pid() -> None:
    """`K_c (1 + 1/(s Ti) + s Td)` over a current loop, an inertia and 1.5 samples, written out here."""
    gains = SERVOS.make("two_loops").design(RE40)
    s = 1j * np.geomspace(1.0, 3000.0, 30)
    K, ki, k, T = gains.speed.gain, gains.speed.integral_gain / 5e-4, gains.position.gain, 5e-4
    pid = K * s + (ki + K * k) + ki * k / s
    inner = (gains.current.gain + gains.current.integral_gain / (s * 1e-4)) / (1.13 + s * 0.33e-3) * np.exp(-1.5e-4 * s)
    wanted = pid * 0.0603 / (4.37e-5 * s**2) * inner / (1.0 + inner) * np.exp(-1.5 * T * s)
    np.testing.assert_allclose(servo_loops(RE40, gains)["angle"](s), wanted, rtol=1e-9)


def test_one_loop_regulates_the_motor_as_it_is() -> None:
    gains = SERVOS.make("one_loop").design(RE40)
    s = 1j * np.geomspace(1.0, 3000.0, 30)
    K, ki, k = gains.speed.gain * 1.13, gains.speed.integral_gain * 1.13 / 5e-4, gains.position.gain
    motor = 0.0603 / ((1.13 + s * 0.33e-3) * 4.37e-5 * s + 0.0603**2)
    wanted = (K + ki / s) * (1.0 + k / s) * motor * np.exp(-0.75e-3 * s)
    np.testing.assert_allclose(servo_loops(RE40, gains)["angle"](s), wanted, rtol=1e-9)


def test_a_notch_is_deep_at_its_frequency_and_nothing_elsewhere() -> None:
    b0, b1, b2, a1, a2 = notch_params(1500.0, 0.05, 0.6, 5e-4)
    found = dlti([b0, b1, b2], [1.0, a1, a2], dt=5e-4)
    _, response = found.freqresp(w=np.array([1e-6, 1500.0 * 5e-4]))
    assert abs(response[0]) == pytest.approx(1.0, rel=1e-6)
    assert abs(response[1]) == pytest.approx(0.05, rel=1e-6)
    assert (np.abs(tf2zpk([b0, b1, b2], [1.0, a1, a2])[1]) < 1.0).all()
    assert dstep(found, n=200)[1][0][-1, 0] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("stiffness", [10.0, 20.0, 40.0])
def test_a_notch_gives_an_elastic_axis_its_margin_back(stiffness: float) -> None:
    """The same gain without the notch is unstable, or nearly: below 20 deg; with it 45 deg are left."""
    axis, times = dataclasses.replace(WHOLE, stiffness=stiffness), SampleTimes()
    gains = SERVOS.make("notch").design(axis)
    assert isinstance(gains, ServoGains)
    bare = gains.law._replace(notch=servo_law().notch)
    loops = law_loops(axis, times, gains.current, gains.speed, gains.position, bare)
    try:
        left = margin_of("speed", loops["speed"], times.speed).phase_margin
    except OutOfLimits:
        left = 0.0
    assert math.degrees(left) < 20.0
    assert math.degrees(gains.margins["speed"].phase_margin) > 44.9
    rigid = design_speed(RE40, times, design_current(RE40, times.current, True))[0]
    assert gains.speed.gain > 0.5 * rigid.gain


@pytest.mark.parametrize(
    ("name", "given", "axis", "text"),
    [
        ("notch", {}, RE40, "the axis is rigid and no frequency is given"),
        ("notch", {"frequency": 7000.0}, RE40, "samples of 0.0005 s show less than 6283"),
        ("load_side", {}, RE40, "has no encoder on its load"),
        ("backlash", {}, RE40, "has no gap and none is given"),
    ],
)
def test_what_a_servo_needs_is_said(name: str, given: dict[str, float], axis: ServoAxis, text: str) -> None:
    with pytest.raises(ModelError, match=text):
        SERVOS.make(name, given).design(axis)


def test_an_elastic_axis_needs_its_load() -> None:
    with pytest.raises(ModelError, match=r"load_inertia is 0\.0; of an elastic axis"):
        dataclasses.replace(RE40, stiffness=20.0)
    assert WHOLE.resonance / (2.0 * math.pi) == pytest.approx(232.089, abs=0.01)  # published case: two-mass
    assert WHOLE.antiresonance / (2.0 * math.pi) == pytest.approx(129.949, abs=0.01)


def random_servo_axis(rng: np.random.Generator) -> ServoAxis:
    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    k = between(0.01, 0.5)
    return ServoAxis(
        between(0.1, 10.0), between(1e-4, 1e-2), k, k, between(1e-6, 1e-2), between(12.0, 300.0), between(1.0, 50.0),
        between(10.0, 5000.0), between(400.0, 1e5), between(1e-7, 1e-3),
    )  # fmt: skip


def test_each_output_is_within_what_the_loop_inside_takes() -> None:
    """Random axes, speeds, errors: position to speed, speed to current, current to voltage, each pair."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        axis = random_servo_axis(rng)
        gains = design_cascade(axis)
        top = drivable_speed(axis)
        assert [w.name for w in gains.warnings if w.name.endswith("_limit")] == ["speed_limit"] * (axis.max_speed > top)
        asked = position_step(gains.position, rng.normal(0.0, 1e4), rng.normal(0.0, 1e4), 0.0)
        lasting = axis.viscous * asked / axis.torque_constant  # current that keeps this speed up
        assert abs(axis.resistance * lasting + axis.back_emf_constant * asked) <= axis.max_voltage * (1.0 + 1e-9)
        rate = rng.uniform(-1.0, 1.0) * axis.max_voltage / axis.back_emf_constant
        current, _ = speed_step(gains.speed, rng.normal(0.0, 10.0), asked, rate, rng.normal(0.0, 10.0))
        assert abs(current) <= axis.max_current
        assert abs(axis.resistance * current + axis.back_emf_constant * rate) <= axis.max_voltage * (1.0 + 1e-9)
        assert gains.speed.max_voltage == gains.current.max_voltage == axis.max_voltage


def test_limits_that_do_not_match_are_named() -> None:
    gains = design_cascade(RE40)
    c, s, p = gains.current, gains.speed, gains.position
    assert unmatched(RE40, c, s, p) == []
    for name, changed in (
        ("speed_limit", (c, s, p._replace(max_speed=900.0))),
        ("current_limit", (c, s._replace(max_current=12.0), p)),
        ("voltage_limit", (c._replace(max_voltage=40.0), s, p)),
        ("voltage_limit", (c._replace(max_voltage=60.0), s, p)),
    ):
        (warning,) = unmatched(RE40, *changed)
        assert warning.name == name
        assert warning.value > warning.wanted
        assert f"{warning.value:.5g}" in warning.text
    fast = dataclasses.replace(RE40, max_speed=900.0)
    (warning,) = design_cascade(fast).warnings
    assert warning.text.startswith("the axis is to turn with 900 rad/s, what is inside gives 796.02 rad/s")
    assert design_cascade(fast).position.max_speed == pytest.approx(48.0 / 0.0603)
