"""The designed cascade: its margins against the sampled loops of scipy.signal, and what limits it."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from one_axis import puma_axis
from scipy import signal

from holonom.control import CascadeGains, SampleTimes, ServoAxis, design_cascade
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


def test_options() -> None:
    gains: CascadeGains = design_cascade(AXIS, max_braking=321.0, feed_back_emf=False)
    assert gains.position.max_braking == 321.0
    assert gains.current.back_emf == 0.0
    assert design_cascade(AXIS).position.max_braking == pytest.approx(0.5 * 0.189 * 8.25 / 8.93e-4)


@pytest.mark.parametrize("field", sorted(asdict(AXIS)))
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_a_bad_number_is_named(field: str, value: float) -> None:
    with pytest.raises(ModelError, match=rf"ServoAxis: {field} is"):
        replace(AXIS, **{field: value})


def test_bad_times_and_options_are_named() -> None:
    with pytest.raises(OutOfLimits, match="no loop slower than the one around it"):
        SampleTimes(1e-3, 5e-4, 1e-3)
    with pytest.raises(OutOfLimits, match="must be positive"):
        SampleTimes(0.0, 5e-4, 1e-3)
    with pytest.raises(OutOfLimits, match="max_braking is 0"):
        design_cascade(AXIS, max_braking=0.0)
