"""Gains from sheets: confirmed by a simulation of its own, on motors that can be bought; limits; what is warned of."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from holonom.closed_loop.axis_tuning import AxisTuning, WantedAxis, trapezoid, try_gains, tune_axis
from holonom.control import SampleTimes
from holonom.control.servo.causes import Cause
from holonom.devices import DcMotor, Encoder, Friction, Gear, motor_card
from holonom.errors import ModelError, OutOfLimits
from holonom.sim import Axis, Load


def axis_with(name: str, current: float) -> Axis:
    motor = motor_card(name).sheet.motor(max_current=current)
    idle = motor.torque_constant * motor.no_load_current
    return Axis(
        motor,
        Load(200.0 * motor.rotor_inertia, coulomb=5.0 * idle),
        Encoder(2000),
        Gear(10.0),
        Friction(0.0, idle, idle),
    )


CATALOGUE = {"maxon_re40_48v": 10.0, "maxon_amax32": 2.5, "faulhaber_3257_24v": 6.0}


def stepped(found: AxisTuning, size: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Joint angle each millisecond and largest current: written from the JSON of `tune` alone, plainly."""
    axis, m, loops = found.axis, found.axis.motor, found.loops
    n, counts = axis.gear.ratio, axis.encoder.counts_per_rev
    J = m.rotor_inertia + axis.load.inertia / n**2
    rub = m.torque_constant * m.no_load_current + axis.load.coulomb / n
    kc, ti = loops["current"].Kc, loops["current"].Ti
    ks, ts = loops["speed"].Kc, loops["speed"].Ti
    most, limit = found.gains.position.max_braking, found.gains.position.max_speed
    th = w = i = ui = ii = i_ref = i_next = w_ref = w_next = w_seen = before = 0.0
    u_next, out, peak = 0.0, [], 0.0
    sub, dt = 4, 1e-4
    for k in range(round(seconds / dt)):
        if k % 10 == 0:
            out.append(th / n)
        if k % 5 == 0:
            seen = (math.floor(th * counts / (2 * math.pi)) + 0.5) * 2 * math.pi / counts
            w_seen += 0.5 * ((seen - before) / 5e-4 - w_seen)  # another filter than the observer: plain smoothing
            before = seen
            if k % 10 == 0:
                w_ref = w_next
                e = n * size - seen
                far = abs(e) > most / loops["position"].Kc ** 2
                braked = math.copysign(math.sqrt(max(most * (2 * abs(e) - most / loops["position"].Kc ** 2), 0)), e)
                w_next = min(max(braked if far else loops["position"].Kc * e, -limit), limit)
            i_ref = i_next
            e, new = w_ref - w_seen, ii + ks * 5e-4 / ts * (w_ref - w_seen)
            i_next = min(max(ks * e + new, -m.max_current), m.max_current)
            ii = new if abs(ks * e + new) <= m.max_current else ii
        u = u_next
        e, new = i_ref - i, ui + kc * 1e-4 / ti * (i_ref - i)
        u_next = min(max(kc * e + new + m.back_emf_constant * w_seen, -m.max_voltage), m.max_voltage)
        ui = new if abs(u_next) < m.max_voltage else ui
        for _ in range(sub):
            i += dt / sub * (u - m.resistance * i - m.back_emf_constant * w) / m.inductance
            free = w + dt / sub * m.torque_constant * i / J
            w = math.copysign(max(abs(free) - dt / sub * rub / J, 0.0), free)
            th += dt / sub * w
        peak = max(peak, abs(i))
    return np.array(out), peak


@pytest.mark.parametrize("name", CATALOGUE)
def test_an_independent_simulation_confirms_the_gains(name: str) -> None:
    found = tune_axis(axis_with(name, CATALOGUE[name]), wanted=WantedAxis(step=0.5))
    assert [w.name for w in found.warnings if w.name != "sample_time"] == []
    position, peak = stepped(found, 0.5, found.step.time[-1])
    settling = np.flatnonzero(np.abs(position - 0.5) > 0.01)[-1] * 1e-3
    assert found.verified.settling_time == pytest.approx(settling, rel=0.1)
    assert found.verified.overshoot_percent < 1.0
    assert position.max() / 0.5 < 1.01
    assert np.abs(found.step.current).max() == pytest.approx(peak, rel=0.1)
    half = [np.flatnonzero(course > 0.25)[0] for course in (position, found.step.position)]
    assert half[0] == pytest.approx(half[1], abs=2)  # ms
    assert found.verified.end_error < 2.0 * 2.0 * math.pi / 20_000 + 1e-3


def test_the_published_trial() -> None:
    """open_cases.json, "trial: tune RE 40 axis"."""
    motor = motor_card("maxon_re40_48v").sheet.motor(max_voltage=48.0, max_current=10.0)
    axis = Axis(motor, Load(3e-5, coulomb=0.002), Encoder(2000), friction=Friction(0.0, 0.004, 0.004))
    found = tune_axis(axis)
    assert found.verified.overshoot_percent <= 1.0
    assert found.verified.settling_time <= 0.15
    assert found.verified.end_error <= 2 * 2.0 * math.pi / 2000
    assert 45.0 <= math.degrees(found.loops["speed"].margin.phase_margin) <= 70.0


def test_gains_bear_an_axis_that_is_not_what_its_sheets_say() -> None:
    axis = axis_with("maxon_re40_48v", 10.0)
    found = tune_axis(axis)
    heavier = dataclasses.replace(found.axis, load=dataclasses.replace(axis.load, inertia=1.3 * axis.load.inertia))
    other = try_gains(found, heavier)
    assert other.overshoot_percent < 3.0
    assert other.following_error < 3.0 * found.verified.following_error
    assert try_gains(found, found.axis).overshoot_percent == found.verified.overshoot_percent


def test_a_winding_gets_as_hot_as_its_current_makes_it() -> None:
    card = motor_card("maxon_re40_48v")
    axis = axis_with("maxon_re40_48v", 10.0)
    found = tune_axis(axis, thermal=card.sheet.thermal())
    rms = math.sqrt(found.move.square_current.mean())
    assert found.verified.winding_temperature == pytest.approx(card.sheet.thermal().settled(rms).winding)
    assert found.verified.winding_temperature < 155.0  # by default a move that the motor bears for ever
    hot = tune_axis(axis, thermal=card.sheet.thermal(), wanted=WantedAxis(acceleration=1000.0))
    assert [w.name for w in hot.warnings] == ["winding_temperature"]
    assert tune_axis(axis).verified.winding_temperature is None


@pytest.mark.parametrize(("size", "speed", "acceleration"), [(1.0, 2.0, 10.0), (1.0, 50.0, 10.0), (3.0, 1.0, 4.0)])
def test_a_trapezoid_keeps_its_limits_and_arrives(size: float, speed: float, acceleration: float) -> None:
    s, v, a = trapezoid(size, speed, acceleration, 1e-3)
    assert s[0] == 0.0
    assert s[-1] == pytest.approx(size, abs=1e-12)
    assert v.max() <= speed * (1.0 + 1e-12)
    assert np.abs(a).max() <= acceleration
    np.testing.assert_allclose(np.gradient(s, 1e-3)[2:-2], v[2:-2], atol=acceleration * 1e-3)


@pytest.mark.parametrize(
    ("changes", "times", "name", "words"),
    [
        ({"encoder": Encoder(200)}, None, "encoder_resolution", "counts are needed"),
        ({"encoder": Encoder(200)}, None, "encoder_supervision", "faults of the encoder are found later"),
        ({}, SampleTimes(5e-4, 1e-3, 2e-3), "sample_time", "L/R is only"),
    ],
)
def test_what_is_too_coarse_is_warned_of(changes: dict, times: SampleTimes | None, name: str, words: str) -> None:
    found = tune_axis(dataclasses.replace(axis_with("maxon_re40_48v", 10.0), **changes), times=times)
    (warning,) = (w for w in found.warnings if w.name == name)
    assert words in warning.text
    assert warning.value != warning.wanted


def test_what_was_wanted_and_does_not_come_out_is_warned_of() -> None:
    wanted = WantedAxis(settling_time=0.01, following_error=1e-6)
    found = tune_axis(axis_with("maxon_re40_48v", 10.0), wanted=wanted)
    assert [w.name for w in found.warnings] == ["wanted_settling_time", "wanted_following_error"]


@pytest.mark.parametrize(
    ("wanted", "text"),
    [
        (WantedAxis(speed=100.0), "48 V give less than 79.6"),
        (WantedAxis(acceleration=1e5), "10 A give at most"),
    ],
)
def test_limits_that_cannot_be_met(wanted: WantedAxis, text: str) -> None:
    with pytest.raises(OutOfLimits, match=text):
        tune_axis(axis_with("maxon_re40_48v", 10.0), wanted=wanted)


def test_an_axis_that_does_not_move_at_all() -> None:
    axis = axis_with("maxon_re40_48v", 10.0)
    with pytest.raises(OutOfLimits, match="this axis does not move"):
        tune_axis(dataclasses.replace(axis, load=Load(1.0, torque=100.0)))


@pytest.mark.parametrize("key", ["speed", "acceleration", "settling_time", "following_error"])
def test_wishes_are_positive(key: str) -> None:
    with pytest.raises(ModelError, match=f"{key} is"):
        WantedAxis(**{key: -1.0})


@pytest.mark.parametrize("stiffness", [300.0, 1000.0, 2500.0, 1e4, 1e5])
def test_an_axis_that_swings_with_its_gains_has_been_warned_of(stiffness: float) -> None:
    """Whatever comes out of an elastic axis, bad steps are not left to be found in the numbers."""
    motor = motor_card("maxon_re25_24v").sheet.motor()
    load = Load(2.66 * motor.rotor_inertia * 45.0**2, 0.001, 1e-4)
    found = tune_axis(Axis(motor, load, Encoder(20_000), Gear(45.0, 0.7), stiffness=stiffness))
    said = {w.name for w in found.warnings}
    crossing, swings = found.gains.speed_margin.crossover, math.sqrt(stiffness / load.inertia)
    assert ("resonance" in said) == (crossing > 0.5 * swings)
    if "resonance" not in said:
        assert said <= {"encoder_supervision", "sample_time"}
        assert found.verified.settling_time < 0.2


LONG_SAMPLES = SampleTimes(current=2.224e-4, speed=1.112e-3, position=2.224e-3)
"""Six electrical time constants of a Faulhaber 2342, which its current loop is warned of."""


@pytest.mark.parametrize(
    ("motor", "axis", "times"),
    [
        (
            motor_card("faulhaber_2342_12v").sheet.motor(),
            {"load": Load(3.209e-4, 0.0612, 5e-6), "encoder": Encoder(19684), "gear": Gear(-6.507, 0.765)},
            LONG_SAMPLES,
        ),
        (
            motor_card("faulhaber_2224_12v").sheet.motor(max_voltage=10.258, max_current=1.586),
            {
                "load": Load(3.402e-5, 1.17e-4, 5.085e-3),
                "encoder": Encoder(12304),
                "gear": Gear(-7.5256, 0.677),
                "gap": 7.8e-4,
                "stiffness": 29.95,
            },
            None,
        ),
    ],
    ids=["samples beyond L/R", "held at a reversal"],
)
def test_a_healthy_axis_is_not_stopped(motor: DcMotor, axis: dict[str, Any], times: SampleTimes | None) -> None:
    """Steps of axes that once stopped for an encoder that was right."""
    found = tune_axis(Axis(motor=motor, **axis), times=times)
    assert not {w.name for w in found.warnings} & {cause.name.lower() for cause in Cause}
