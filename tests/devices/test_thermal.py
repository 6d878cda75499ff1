"""Winding and housing: the exact step against a stiff solver, limits, duty."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from holonom.devices import Temperatures, ThermalModel, thermal_step
from holonom.errors import ModelError, OutOfLimits

RE40 = ThermalModel(1.13, 4.65, 1.93, 41.5, 809.0)


def random_model(rng: np.random.Generator) -> ThermalModel:
    r = np.exp(rng.uniform(np.log(0.2), np.log(5.0), 5))
    return ThermalModel(r[0], 5.0 * r[1], 2.0 * r[2], 20.0 * r[3], 600.0 * r[4], ambient=rng.uniform(-10.0, 60.0))


def solved(m: ThermalModel, start: Temperatures, current: float, time: float) -> np.ndarray:
    """Both temperatures by another way: the two balances, as the book has them, with LSODA."""
    c_w, c_h = m.winding_time / m.winding_to_housing, m.housing_time / m.housing_to_air

    def rates(_: float, T: np.ndarray) -> list[float]:
        losses = m.resistance * (1.0 + m.coefficient * (T[0] - 25.0)) * current**2
        flow = (T[0] - T[1]) / m.winding_to_housing
        return [(losses - flow) / c_w, (flow - (T[1] - m.ambient) / m.housing_to_air) / c_h]

    return solve_ivp(rates, (0.0, time), start, method="LSODA", rtol=1e-10, atol=1e-9).y[:, -1]


@pytest.mark.parametrize("seed", range(10))
def test_a_step_of_any_length_is_exact(seed: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(rng)
    start = Temperatures(*(model.ambient + rng.uniform(0.0, 80.0, 2)))
    current, time = rng.uniform(0.0, 1.5) * model.largest_current(), rng.uniform(0.1, 500.0)
    found = thermal_step(model.params(), start, current, time)
    np.testing.assert_allclose(found, solved(model, start, current, time), rtol=1e-7)
    half = thermal_step(model.params(), start, current, 0.5 * time)
    np.testing.assert_allclose(thermal_step(model.params(), half, current, 0.5 * time), found, rtol=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_the_largest_current_settles_at_the_limit(seed: int) -> None:
    model = random_model(np.random.default_rng(seed))
    largest = model.largest_current()
    assert model.settled(largest).winding == pytest.approx(155.0)
    assert thermal_step(model.params(), model.cold(), largest, 1e6).winding == pytest.approx(155.0)
    assert model.time_to(0.99 * largest) == math.inf
    reached = model.time_to(1.7 * largest)
    assert thermal_step(model.params(), model.cold(), 1.7 * largest, reached).winding == pytest.approx(155.0)
    assert model.time_to(1.7 * largest, start=model.settled(0.9 * largest)) < reached
    assert model.time_to(largest, start=Temperatures(160.0, 30.0)) == 0.0


@pytest.mark.parametrize("period", [10.0, 60.0, 2000.0])
def test_duty_by_running_many_cycles(period: float) -> None:
    current = 2.0 * RE40.largest_current()
    part = RE40.duty(current, period)
    assert 0.0 < part < 0.3
    state = RE40.cold()
    for _ in range(int(max(10.0, 20.0 * 809.0 / period))):
        state = thermal_step(RE40.params(), state, 0.0, (1.0 - part) * period)
        state = thermal_step(RE40.params(), state, current, part * period)
    assert state.winding == pytest.approx(155.0, abs=0.05)
    assert RE40.duty(0.9 * RE40.largest_current(), period) == 1.0


def test_fast_cycles_heat_as_their_rms_current() -> None:
    assert RE40.duty(2.0 * RE40.largest_current(), 0.01) == pytest.approx(0.25, rel=1e-3)


def test_runaway_is_told() -> None:
    with pytest.raises(OutOfLimits, match="never settle"):
        RE40.settled(10.0)
    assert RE40.hottest(10.0, 1.0, 1.0) == math.inf
    assert thermal_step(RE40.params(), RE40.cold(), 10.0, 1000.0).winding > 1e4
    with pytest.raises(ModelError, match="limit"):
        replace(RE40, limit=20.0)
    with pytest.raises(ModelError, match="current"):
        RE40.settled(math.nan)
