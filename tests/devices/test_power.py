"""Bridge, supply, current limiter."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from holonom.devices import (
    CurrentLimiter,
    DcMotor,
    PwmBridge,
    Supply,
    armature_step,
    bridge_voltage,
    limiter_voltage,
    supply_step,
)
from holonom.errors import ModelError


def test_published_bridge(data_folder: Path) -> None:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text())
    found = next(one for one in cases if one["id"] == "unipolar PWM")
    g = found["input"]
    bridge = PwmBridge(g["Udc"], g["frequency"], g["dead_time"])
    assert bridge.ripple(g["L"]) == pytest.approx(found["expected"]["largest_ripple_pp"], rel=found["tol"])
    assert bridge.dead_time_voltage == pytest.approx(found["expected"]["dead_time_voltage"], rel=found["tol"])


@pytest.mark.parametrize("switching", ["unipolar", "bipolar", "interleaved"])
@pytest.mark.parametrize("duty", [0.2, 0.5, 0.7])
def test_ripple_by_integrating_the_pulses(switching: str, duty: float) -> None:
    bridge, n = PwmBridge(48.0, 20e3, switching=switching), 20000
    phase = (np.arange(n) + 0.5) / n
    if switching == "interleaved":  # each leg by its own triangle: half of the clock apart
        triangle = np.abs(2.0 * phase - 1.0)
        pulses = (triangle < 0.5 * (1.0 + duty)).astype(float) - (triangle < 0.5 * (1.0 - duty))
    else:
        pulses = np.where(phase < duty, 1.0, -1.0 if switching == "bipolar" else 0.0)
    drive = 48.0 * (pulses - pulses.mean())
    current = np.cumsum(drive) / 0.33e-3 / 20e3 / n
    assert np.ptp(current) == pytest.approx(bridge.ripple(0.33e-3, duty), rel=1e-3)
    assert bridge.ripple(0.33e-3, duty) <= bridge.ripple(0.33e-3) * (1.0 + 1e-12)


def test_dead_time_takes_voltage_against_the_current() -> None:
    bridge = PwmBridge(48.0, 20e3, 1e-6, resistance=0.1)
    params = bridge.params()
    assert bridge_voltage(params, 10.0, 2.0, 48.0) == pytest.approx(10.0 - 0.96 - 0.2)
    assert bridge_voltage(params, 10.0, -2.0, 48.0) == pytest.approx(10.0 + 0.96 + 0.2)
    assert bridge_voltage(params, 10.0, 0.0, 48.0) == 10.0
    assert bridge_voltage(params, 100.0, 0.0, 40.0) == pytest.approx(0.96 * 40.0)
    assert bridge_voltage(params, -100.0, 0.0, 40.0) == pytest.approx(-0.96 * 40.0)
    with pytest.raises(ModelError, match="dead_time"):
        PwmBridge(48.0, 20e3, 26e-6)
    with pytest.raises(ModelError, match="duty"):
        bridge.ripple(1e-3, 1.5)


def linked(s: Supply, start: float, current: float, time: float) -> float:
    """The link's balance by a solver of another kind."""

    def rate(_: float, u: np.ndarray) -> list[float]:
        fed = (s.voltage - u[0]) / s.resistance
        return [((fed if s.regenerates else max(fed, 0.0)) - current) / s.capacity]

    return float(solve_ivp(rate, (0.0, time), [start], method="LSODA", rtol=1e-10, atol=1e-10, max_step=1e-5).y[0, -1])


@pytest.mark.parametrize("regenerates", [True, False])
@pytest.mark.parametrize("start", [45.0, 48.0, 52.0])
@pytest.mark.parametrize("current", [30.0, 2.0, 0.0, -20.0])
def test_a_step_of_the_supply_is_that_of_a_solver(regenerates: bool, start: float, current: float) -> None:
    supply = Supply(48.0, 0.1, 4.7e-3, regenerates)
    for time in (1e-4, 2e-3):
        found = supply_step(supply.params(), start, current, time)
        assert found == pytest.approx(linked(supply, start, current, time), rel=1e-5)


def test_a_supply_sags_and_a_chopper_burns() -> None:
    supply = Supply(48.0, 0.1, 4.7e-3, False, 60.0)
    sagged = supply.sagged(1000.0)
    assert (supply.voltage - sagged) / supply.resistance * sagged == pytest.approx(1000.0)
    voltage = 48.0
    for _ in range(10000):
        voltage = supply_step(supply.params(), voltage, 1000.0 / voltage, 1e-4)
    assert voltage == pytest.approx(sagged, rel=1e-6)
    for _ in range(1000):
        voltage = supply_step(supply.params(), voltage, -5.0, 1e-4)
    assert voltage == 60.0
    with pytest.raises(ModelError, match="at most 5760 W"):
        supply.sagged(6000.0)
    with pytest.raises(ModelError, match="chopper_voltage"):
        Supply(48.0, 0.1, 4.7e-3, False, 40.0)


@pytest.mark.parametrize("asked", [48.0, -48.0, 5.0])
def test_the_limiter_holds_a_stalled_motor_near_its_band(asked: float) -> None:
    motor = DcMotor(1.13, 0.33e-3, 0.0603, 0.0603, 1.37e-5, 48.0, 42.0)
    dt = 1e-5
    limiter = CurrentLimiter(10.0, 0.5 * CurrentLimiter(10.0, 1.0).largest_gain(0.33e-3, 1.13, dt))
    current, armature = 0.0, motor.armature(dt)
    for _ in range(4000):
        current = armature_step(armature, current, limiter_voltage(limiter.params(), asked, current), 0.0)
    assert current == pytest.approx(limiter.stall_current(asked, 1.13), rel=1e-9)
    assert abs(current) < 11.2
    assert limiter_voltage(limiter.params(), 7.0, 9.9) == 7.0


@pytest.mark.parametrize(("part", "settles"), [(0.95, True), (1.05, False)])
def test_the_largest_gain_of_the_limiter(part: float, settles: bool) -> None:
    dt, R, L = 1e-5, 1.13, 0.33e-3
    limiter = CurrentLimiter(10.0, part * CurrentLimiter(10.0, 1.0).largest_gain(L, R, dt))
    decay, current = math.exp(-R * dt / L), 10.5
    deviation = []
    for _ in range(2000):
        settled = limiter_voltage(limiter.params(), 48.0, current) / R
        current = settled + decay * (current - settled)
        deviation.append(abs(current - limiter.stall_current(48.0, R)))
    assert (deviation[-1] < 1e-6) == settles
