"""The DC motor: exact sampling, transfer functions, energy, a printed data sheet."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, signal

from holonom.devices import DcMotor, armature_step
from holonom.devices.motors.dc_motor import mean_weight
from holonom.errors import ModelError

# Maxon RE 40, 24 V, 150 W (catalogue number 148867)
RE40 = DcMotor(0.299, 82.3e-6, 30.2e-3, 30.2e-3, 142e-7, 24.0, 80.2, no_load_current=0.137)
PUMA1 = DcMotor(2.1, 4.9e-3, 0.189, 0.189, 2e-4, 40.0, 8.25)
LIGHT = replace(PUMA1, rotor_inertia=5e-5)


def run_free(motor: DcMotor, voltage: float, load: float, inertia: float, dt: float, steps: int) -> np.ndarray:
    """Speed of the motor with an added inertia, from rest: a fine mixed step, independent of the exact one."""
    params = motor.armature(dt)
    step = armature_step.py_func
    speed, current = np.zeros(steps), 0.0
    for k in range(1, steps):
        after = step(params, current, voltage, speed[k - 1])
        torque = motor.torque_constant * 0.5 * (current + after) - load
        speed[k] = speed[k - 1] + dt * torque / (motor.rotor_inertia + inertia)
        current = after
    return speed


@pytest.mark.parametrize("dt", [1e-5, 1e-4, 5e-3])
def test_locked_rotor_follows_the_exponential_whatever_the_interval(dt: float) -> None:
    params = PUMA1.armature(dt)
    current = 0.0
    for k in range(1, 30):
        current = armature_step(params, current, 10.0, 0.0)
        exact = 10.0 / 2.1 * (1.0 - math.exp(-k * dt / PUMA1.electrical_time_constant))
        assert current == pytest.approx(exact, rel=1e-12)


@given(current=st.floats(-8, 8), voltage=st.floats(-60, 60), speed=st.floats(-100, 100), dt=st.floats(1e-6, 1e-2))
def test_two_half_steps_are_one_step(current: float, voltage: float, speed: float, dt: float) -> None:
    half, whole = PUMA1.armature(0.5 * dt), PUMA1.armature(dt)
    twice = armature_step(half, armature_step(half, current, voltage, speed), voltage, speed)
    assert twice == pytest.approx(armature_step(whole, current, voltage, speed), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("times", [1e-6, 0.99e-4, 1.01e-4, 0.1, 1.0, 6.5, 50.0])
def test_the_mean_current_is_that_of_the_exponential(times: float) -> None:
    """Over an interval of so many electrical time constants; by quadrature."""
    first, settled = 1.7, -0.4
    current = settled + (first - settled) * np.exp(-np.linspace(0.0, times, 20001))
    weight = mean_weight(times)
    mean = integrate.simpson(current, dx=1.0 / 20000)
    assert (1.0 - weight) * first + weight * current[-1] == pytest.approx(mean, abs=1e-9)


def test_the_supply_limits_the_voltage() -> None:
    params = PUMA1.armature(1e-4)
    assert armature_step(params, 1.0, 500.0, 3.0) == armature_step(params, 1.0, 40.0, 3.0)
    assert armature_step(params, 1.0, -500.0, 3.0) == armature_step(params, 1.0, -40.0, 3.0)
    assert armature_step(params, 1.0, 39.0, 3.0) < armature_step(params, 1.0, 40.0, 3.0)


@pytest.mark.parametrize(("motor", "inertia"), [(LIGHT, 0.0), (PUMA1, 7e-4)], ids=["oscillating", "aperiodic"])
def test_speed_follows_the_transfer_functions(motor: DcMotor, inertia: float) -> None:
    dt, steps = 5e-6, 8000
    tm, tv = motor.mechanical_time_constant(inertia), motor.electrical_time_constant
    assert (motor.damping(inertia) < 1.0) == (tm < 4.0 * tv)
    times = dt * np.arange(steps)
    denominator = [tm * tv, tm, 1.0]
    by_voltage = signal.step(signal.lti([motor.speed_gain], denominator), T=times)[1]
    by_load = signal.step(signal.lti([motor.load_gain * tv, motor.load_gain], denominator), T=times)[1]
    np.testing.assert_allclose(run_free(motor, 12.0, 0.0, inertia, dt, steps), 12.0 * by_voltage, atol=0.05)
    np.testing.assert_allclose(run_free(motor, 0.0, 0.3, inertia, dt, steps), 0.3 * by_load, atol=0.01)


def test_a_light_rotor_overshoots_and_a_heavy_one_does_not() -> None:
    final = 12.0 * PUMA1.speed_gain
    light = run_free(LIGHT, 12.0, 0.0, 0.0, 1e-5, 6000)
    heavy = run_free(PUMA1, 12.0, 0.0, 7e-4, 1e-5, 40000)
    assert LIGHT.damping() < 1.0 < PUMA1.damping(7e-4)
    assert light.max() > 1.1 * final
    assert heavy.max() <= final
    assert heavy[-1] == pytest.approx(final, rel=1e-3)


def test_electrical_energy_is_heat_magnetic_and_mechanical() -> None:
    motor, dt, inertia = PUMA1, 2e-6, 3e-4
    params, step = motor.armature(dt), armature_step.py_func
    current = speed = electrical = heat = mechanical = 0.0
    for k in range(20000):
        voltage = 15.0 * math.sin(400.0 * k * dt)
        after = step(params, current, voltage, speed)
        mean = 0.5 * (current + after)
        electrical += voltage * mean * dt
        heat += motor.resistance * (current**2 + current * after + after**2) / 3.0 * dt
        mechanical += motor.back_emf_constant * mean * speed * dt
        speed += dt * motor.torque_constant * mean / inertia
        current = after
    magnetic = 0.5 * motor.inductance * current**2
    assert electrical > 0.01
    assert electrical == pytest.approx(heat + magnetic + mechanical, rel=1e-5)
    assert mechanical == pytest.approx(0.5 * inertia * speed**2, rel=1e-2)


def test_the_printed_data_sheet_of_a_maxon_re_40() -> None:
    rpm = math.pi / 30.0
    assert RE40.mechanical_time_constant() == pytest.approx(4.67e-3, rel=0.005)
    assert RE40.stall_torque == pytest.approx(2.42, rel=0.005)
    assert RE40.no_load_speed == pytest.approx(7580 * rpm, rel=0.005)
    assert RE40.speed_gain == pytest.approx(317 * rpm, rel=0.005)
    assert -RE40.load_gain == pytest.approx(3.14 * rpm / 1e-3, rel=0.01)  # speed/torque gradient, rpm/mN m


@pytest.mark.parametrize("field", sorted(asdict(RE40)))
@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
def test_a_bad_field_is_named(field: str, value: float) -> None:
    with pytest.raises(ModelError, match=rf"DcMotor: {field} is .*; it must be finite and"):
        DcMotor(**{**asdict(RE40), field: value})


def test_an_interval_must_be_positive() -> None:
    with pytest.raises(ModelError, match="dt is 0"):
        RE40.armature(0.0)
