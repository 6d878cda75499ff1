"""The designed cascade: its margins against the sampled loops of scipy.signal, and what limits it."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from one_axis import puma_axis
from scipy import signal

from holonom.control import CascadeGains, SampleTimes, ServoAxis, design_cascade
from holonom.control.margins import margin_of
from holonom.control.servo import cascade
from holonom.errors import ModelError, OutOfLimits

AXIS = ServoAxis(
    resistance=2.1,
    inductance=4.9e-3,
    torque_constant=0.189,
    back_emf_constant=0.189,
    inertia=8.93e-4,
    max_voltage=40.0,
    max_current=8.25,
    max_speed=89.6,
    counts_per_rev=4000,
    viscous=1.48e-3,
)


def sampled_margin(numerator: list[float], denominator: list[float], pi: tuple[float, float], dt: float):
    """Crossover and margin of PI(z) z^-1 plant(z), the plant sampled with a hold: the exact sampled loop."""
    top, bottom, _ = signal.cont2discrete((numerator, denominator), dt, method="zoh")
    gain, integral_gain = pi
    loop = signal.dlti(
        np.polymul(top.ravel(), [gain + integral_gain, -gain]),
        np.polymul(np.polymul(bottom, [1.0, -1.0]), [1.0, 0.0]),
        dt=dt,
    )
    w = np.geomspace(1e-4, 0.999 * math.pi, 200_000) / dt
    response = signal.dfreqresp(loop, w * dt)[1]
    k = int(np.flatnonzero(np.abs(response) > 1.0)[-1])
    return w[k], math.pi + np.unwrap(np.angle(response))[k]


def test_current_margin_is_the_one_of_the_sampled_loop() -> None:
    gains = design_cascade(AXIS)
    crossover, margin = sampled_margin(
        [1.0], [AXIS.inductance, AXIS.resistance], (gains.current.gain, gains.current.integral_gain), 1e-4
    )
    assert gains.current_margin.crossover == pytest.approx(crossover, rel=0.03)
    assert math.degrees(gains.current_margin.phase_margin) == pytest.approx(math.degrees(margin), abs=2.0)
    assert math.degrees(margin) == pytest.approx(60.0, abs=3.0)


def test_speed_margin_is_the_one_of_the_sampled_loop() -> None:
    """The current loop as the lag of 1 / (1 + s T_V / K) with its own delay as a second small one."""
    gains = design_cascade(AXIS)
    lag = np.polymul([AXIS.inductance / gains.current.gain, 1.0], [AXIS.inertia, AXIS.viscous])
    crossover, margin = sampled_margin(
        [AXIS.torque_constant], lag.tolist(), (gains.speed.gain, gains.speed.integral_gain), 5e-4
    )
    assert gains.speed_margin.crossover == pytest.approx(crossover, rel=0.05)
    assert math.degrees(gains.speed_margin.phase_margin) == pytest.approx(math.degrees(margin), abs=4.0)
    assert math.degrees(margin) == pytest.approx(55.0, abs=5.0)


@pytest.mark.parametrize("number", range(1, 7))
def test_every_puma_axis_has_its_margins(number: int) -> None:
    gains = puma_axis(number)[1]
    assert 500.0 < gains.current_margin.crossover / (2.0 * math.pi) < 1000.0
    assert 30.0 < gains.speed_margin.crossover / (2.0 * math.pi) < 80.0
    assert math.degrees(gains.speed_margin.phase_margin) > 50.0
    assert 10.0 < gains.position.gain < 40.0
    assert math.degrees(gains.position_margin.phase_margin) > 80.0


def test_a_coarse_encoder_slows_the_speed_loop() -> None:
    fine, coarse = design_cascade(AXIS), design_cascade(replace(AXIS, counts_per_rev=500))
    assert fine.speed_limited_by == "sample time"
    assert coarse.speed_limited_by == "encoder resolution"
    assert coarse.speed.gain < 0.7 * fine.speed.gain
    count = 2.0 * math.pi / 500
    assert coarse.speed.gain * 0.8 * coarse.observer_bandwidth * count == pytest.approx(0.2 * 8.25)


def test_faster_sampling_gives_faster_loops() -> None:
    slow, fast = design_cascade(AXIS), design_cascade(AXIS, times=SampleTimes(5e-5, 2.5e-4, 5e-4))
    assert fast.current.gain == pytest.approx(2.0 * slow.current.gain)
    assert fast.speed.gain > slow.speed.gain


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_a_design_of_any_axis_keeps_its_margins_at_any_sample_times(seed: int) -> None:
    """Friction that is large against the inertia included: the zero then cancels the lag J / B."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    axis = ServoAxis(
        resistance=between(0.05, 20.0), inductance=between(1e-5, 2e-2), torque_constant=between(5e-3, 2.0),
        back_emf_constant=between(5e-3, 2.0), inertia=between(1e-7, 0.1), max_voltage=48.0,
        max_current=between(0.5, 50.0), max_speed=300.0, counts_per_rev=between(100.0, 1e6),
        viscous=between(1e-7, 10.0),
    )  # fmt: skip
    step = between(2e-5, 1e-3)
    times = SampleTimes(step, step * int(rng.integers(1, 10)), step * int(rng.integers(10, 30)))
    gains = design_cascade(axis, times=times)
    for name, least in (("current", 59.0), ("speed", 50.0), ("position", 60.0)):
        margin = getattr(gains, f"{name}_margin")
        assert math.degrees(margin.phase_margin) > least
        assert margin.gain_margin > 2.5
    too_slow = step > axis.inductance / axis.resistance
    too_fast = axis.max_speed * (1.0 + 1e-9) > 48.0 / (
        axis.back_emf_constant + axis.resistance * axis.viscous / axis.torque_constant
    )
    assert [w.name for w in gains.warnings] == ["sample_time"] * too_slow + ["speed_limit"] * too_fast


def test_a_margin_that_is_not_reached_is_said_with_its_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(cascade.LEAST_MARGINS, "speed", 80.0)
    (warning,) = design_cascade(AXIS).warnings
    assert warning.name == "speed_phase_margin"
    assert warning.value == pytest.approx(54.5, abs=0.1)
    assert warning.text.startswith("the speed loop keeps 54.5 deg of phase at 318.8 rad/s; 80 are wanted")


def test_a_loop_that_would_be_unstable_is_refused() -> None:
    integrator = margin_of("some", lambda s: 100.0 / s * np.exp(-1.5e-3 * s), 1e-3)
    assert integrator.crossover == pytest.approx(100.0, rel=1e-4)
    assert integrator.phase_margin == pytest.approx(math.pi / 2 - 0.15, abs=1e-4)
    assert integrator.gain_margin == pytest.approx(math.pi / 2 / 0.15, rel=1e-3)
    with pytest.raises(OutOfLimits, match="the some loop is unstable at a sample time"):
        margin_of("some", lambda s: 1100.0 / s * np.exp(-1.5e-3 * s), 1e-3)


def test_options() -> None:
    gains: CascadeGains = design_cascade(AXIS, max_braking=321.0, feed_back_emf=False)
    assert gains.position.max_braking == 321.0
    assert gains.current.back_emf == 0.0
    assert design_cascade(AXIS).position.max_braking == pytest.approx(0.5 * 0.189 * 8.25 / 8.93e-4)


@pytest.mark.parametrize("field", sorted(asdict(AXIS)))
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_a_bad_number_is_named(field: str, value: float) -> None:
    if (field, value) == ("stiffness", math.inf):
        return  # a rigid axis
    with pytest.raises(ModelError, match=rf"ServoAxis: {field} is"):
        replace(AXIS, **{field: value})


def test_bad_times_and_options_are_named() -> None:
    with pytest.raises(OutOfLimits, match="no loop slower than the one around it"):
        SampleTimes(1e-3, 5e-4, 1e-3)
    with pytest.raises(OutOfLimits, match="must be positive"):
        SampleTimes(0.0, 5e-4, 1e-3)
    with pytest.raises(OutOfLimits, match="max_braking is 0"):
        design_cascade(AXIS, max_braking=0.0)
