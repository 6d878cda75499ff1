"""One axis: its plant against closed forms and a stiff solver, rest, and its servo as the published trial asks."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import holonom as hm
from holonom.control import CascadeGains, SampleTimes, design_cascade
from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.errors import ModelError, OutOfLimits, ShapeError
from holonom.sim import Axis, Load
from holonom.sim.axis.kernels import AxisPlantParams, AxisState, axis_step
from holonom.trace.code.loops import loop

RE40 = DcMotor(1.13, 0.33e-3, 0.0603, 0.0603, 1.37e-5, 48.0, 10.0)
"""maxon 148877 with a power stage of 10 A."""
PLAIN = Axis(RE40, Load(3e-5), Encoder(2000))
RUBBING = dataclasses.replace(PLAIN, load=Load(3e-5, coulomb=0.002), friction=Friction(0.0, 0.004, 0.004))
LOOSE = dataclasses.replace(RUBBING, gap=0.01)
ELASTIC = dataclasses.replace(PLAIN, stiffness=20.0)
DT = 1e-4


@loop(error_model="numpy")
def _turn(params, state, voltages, load, out):
    out[0] = state
    for k in range(len(voltages)):
        state = axis_step(params, state, voltages[k], load)
        out[k + 1] = state


def run(
    axis: Axis, voltages: np.ndarray, load: float = 0.0, state: AxisState | None = None, dt: float = DT
) -> np.ndarray:
    """States (n + 1, 6) under held voltages (n,) and a load at the motor's shaft."""
    return turn(axis.plant(dt), state or axis.at(), voltages, load)


def turn(params: AxisPlantParams, state: AxisState, voltages: np.ndarray, load: float) -> np.ndarray:
    out = np.empty((len(voltages) + 1, 6))
    _turn(params, state, voltages, load, out)
    return out


def test_a_rigid_axis_is_what_a_stiff_solver_makes_of_its_equations() -> None:
    axis = Axis(RE40, Load(0.003, viscous=0.02), Encoder(2000), Gear(10.0), Friction(1e-5, 0.0, 0.0))
    inertia, viscous = 1.37e-5 + 3e-5, 1e-5 + 2e-4

    def rates(t: float, y: np.ndarray) -> list[float]:
        current, speed, _ = y
        voltage = 24.0 if t < 0.02 else -12.0
        return [
            (voltage - 1.13 * current - 0.0603 * speed) / 0.33e-3,
            (0.0603 * current - viscous * speed) / inertia,
            speed,
        ]

    first = solve_ivp(rates, (0.0, 0.02), [0.0] * 3, method="Radau", rtol=1e-10, atol=1e-12, max_step=1e-3)
    exact = solve_ivp(rates, (0.02, 0.05), first.y[:, -1], method="Radau", rtol=1e-10, atol=1e-12, max_step=1e-3)
    found = run(axis, np.where(np.arange(5000) * 1e-5 < 0.02 - 1e-9, 24.0, -12.0), dt=1e-5)[-1]
    np.testing.assert_allclose(found[:3], exact.y[:, -1], rtol=1e-3)


def test_an_elastic_axis_swings_at_its_resonance() -> None:
    """sqrt(k (1/J_M + 1/J_L)), motor without current: 232.09 Hz (published case)."""
    open_circuit = dataclasses.replace(RE40, torque_constant=1e-9, back_emf_constant=1e-9)
    axis = dataclasses.replace(ELASTIC, motor=open_circuit)
    states = run(axis, np.zeros(20_000), state=AxisState(0.0, 0.0, 0.01, 0.0, 0.0, 0.0), dt=1e-5)
    twist = states[:, 2] - states[:, 4]
    crossings = np.flatnonzero((twist[:-1] < 0.0) & (twist[1:] >= 0.0))
    frequency = (len(crossings) - 1) / ((crossings[-1] - crossings[0]) * 1e-5)
    assert frequency == pytest.approx(232.089, rel=3e-3)


@pytest.mark.parametrize("axis", [PLAIN, ELASTIC], ids=["rigid", "elastic"])
@pytest.mark.parametrize("part", [0.1, 1.5, 30.0])
def test_viscous_friction_of_any_size_only_brakes(axis: Axis, part: float) -> None:
    """Of `part` J/dt: the speed dies out without changing its sign; a torque ends at the speed torque/B."""
    viscous = part * 3e-5 / DT
    open_circuit = dataclasses.replace(RE40, torque_constant=1e-9, back_emf_constant=1e-9)
    thick = dataclasses.replace(axis, motor=open_circuit, load=Load(3e-5, viscous=viscous))
    states = run(thick, np.zeros(400), state=AxisState(0.0, 50.0, 0.0, 50.0, 0.0, 0.0))
    assert np.isfinite(states).all()
    assert abs(states[-1, 3]) < 1e-3 * 50.0
    if axis.rigid:
        assert (states[:, 3] >= -1e-9).all()
    pushed = run(thick, np.zeros(20_000), load=-0.5)
    assert pushed[-1, 3] == pytest.approx(0.5 / viscous, rel=1e-6)


@pytest.mark.parametrize("axis", [RUBBING, LOOSE], ids=["rigid", "with a gap"])
def test_under_a_load_below_breakaway_it_stands(axis: Axis) -> None:
    load = 0.9 * (0.002 if axis.gap else 0.006)
    states = run(axis, np.zeros(600_000), load=load)  # a minute
    settled = states[10_000:]
    assert np.ptp(settled[:, 2]) < 1e-12
    assert np.ptp(settled[:, 4]) < 1e-12


def test_it_comes_to_rest_as_the_closed_form_says() -> None:
    """Published case: 50 rad/s against 0.05 N m of friction, 0.03 N m of load pushing on: 0.25 s, 6.25 rad."""
    motor = dataclasses.replace(RE40, rotor_inertia=0.5e-4, torque_constant=1e-12, back_emf_constant=1e-12)
    axis = Axis(motor, Load(0.5e-4), Encoder(2000), friction=Friction(0.0, 0.05, 0.05))
    states = run(axis, np.zeros(5000), load=-0.03, state=AxisState(0.0, 50.0, 0.0, 50.0, 0.0, 0.0))
    stopped = np.flatnonzero(states[:, 1] == 0.0)[0]
    assert stopped * DT == pytest.approx(0.25, abs=2e-4)
    assert states[-1, 2] == pytest.approx(6.25, rel=0.002)
    assert (states[stopped:, 1] == 0.0).all()


@pytest.mark.parametrize("stiffness", [math.inf, 2000.0])
@pytest.mark.parametrize("efficiency", [1.0, 0.8, 0.4])
def test_a_gear_takes_its_part_both_ways_and_holds_in_between(efficiency: float, stiffness: float) -> None:
    """Torques of the motor that lift a load, hold it, and let it down: T / eta, anything between, T eta."""
    axis = dataclasses.replace(PLAIN, gear=Gear(1.0, efficiency), stiffness=stiffness)
    params, load = axis.plant(DT), 0.2
    held = params._replace(
        torque_before=0.5, torque_after=0.5, armature=params.armature._replace(decay=1.0), damping=0.01
    )

    def speed(torque: float) -> float:
        bent = load / held.stiffness if not axis.rigid else 0.0
        state = AxisState(torque, 0.0, bent, 0.0, 0.0, load)
        return turn(held, state, np.zeros(400), load)[-200:, 3].mean()

    assert speed(1.03 * load / efficiency) > 1.0
    assert speed(0.97 * load * efficiency) < -1.0
    if efficiency < 1.0:
        for part in (0.05, 0.5, 0.95):
            assert abs(speed(load * (efficiency + part * (1.0 / efficiency - efficiency)))) < 1e-3


def test_a_loose_load_floats_in_its_gap() -> None:
    """The rotor turns through the gap and takes the load along: momentum is kept, up to the friction."""
    open_circuit = dataclasses.replace(RE40, torque_constant=1e-12, back_emf_constant=1e-12)
    axis = dataclasses.replace(LOOSE, motor=open_circuit, load=Load(3e-5), friction=Friction())
    states = run(axis, np.zeros(200), state=AxisState(0.0, 10.0, 0.0, 0.0, 0.0, 0.0))
    touched = np.flatnonzero(states[:, 3] != 0.0)[0]
    assert touched * DT == pytest.approx(0.005 / 10.0, abs=2e-4)  # half a gap
    assert (states[:touched, 4] == 0.0).all()
    momentum = 1.37e-5 * states[:, 1] + 3e-5 * states[:, 3]
    np.testing.assert_allclose(momentum, 1.37e-4, rtol=1e-9)
    energy = 0.5 * (1.37e-5 * states[:, 1] ** 2 + 3e-5 * states[:, 3] ** 2)
    assert (energy <= energy[0] * (1.0 + 1e-9)).all()  # contact never gives any
    assert np.abs(states[:, 2] - states[:, 4]).max() < 1.5 * 0.005


def test_the_published_trial_of_an_axis() -> None:
    """open_cases.json, "trial: tune RE 40 axis": a step of 1 rad."""
    gains = design_cascade(RUBBING.servo_axis())
    found = hm.sim.simulate_axis(RUBBING, gains, np.ones(1000))
    assert found.position.max() < 1.01
    assert np.flatnonzero(np.abs(found.position - 1.0) > 0.02)[-1] * 1e-3 < 0.15
    assert abs(found.position[-1] - 1.0) < 2.0 * 2.0 * math.pi / 2000
    assert 45.0 < math.degrees(gains.speed_margin.phase_margin) < 70.0
    assert np.abs(found.current).max() < 10.5
    assert np.abs(found.voltage).max() <= 48.0


@pytest.mark.parametrize("axis", [RUBBING, LOOSE], ids=["rigid", "with a gap"])
def test_a_profile_is_followed_at_the_joint(axis: Axis) -> None:
    geared = dataclasses.replace(axis, gear=Gear(-20.0, 0.8), load=Load(0.01, coulomb=0.05), gap=axis.gap / 20.0)
    gains = design_cascade(geared.servo_axis())
    t = np.arange(0.0, 1.0, 1e-3)
    s = np.minimum(t / 0.6, 1.0)
    w = 2.0 * math.pi / 0.6
    course = s - np.sin(2.0 * math.pi * s) / (2.0 * math.pi)
    speed = np.where(s < 1.0, (1.0 - np.cos(w * t)) / 0.6, 0.0)
    acceleration = np.where(s < 1.0, w * np.sin(w * t) / 0.6, 0.0)
    found = hm.sim.simulate_axis(geared, gains, np.stack([course, speed, acceleration]), load_torque=0.5)
    assert np.abs(found.position - found.reference)[300:].max() < 0.01
    assert abs(found.position[-1] - 1.0) < 1e-3 + axis.gap / 20.0
    blind = hm.sim.simulate_axis(geared, gains, np.stack([course, speed, acceleration]), feed_forward=False)
    assert np.abs(blind.position - blind.reference).max() > 0.05


def test_speed_and_current_alone() -> None:
    gains = design_cascade(PLAIN.servo_axis())
    turning = hm.sim.simulate_axis(PLAIN, gains, np.full(400, 100.0), loop="speed", load_torque=0.05)
    assert turning.speed[-100:].mean() == pytest.approx(100.0, rel=2e-3)
    assert turning.current[-100:].mean() == pytest.approx(0.05 / 0.0603, rel=0.02)
    pushing = hm.sim.simulate_axis(PLAIN, gains, np.full(10, 2.0), loop="current")
    assert pushing.current[5:] == pytest.approx(2.0, rel=0.01)


def test_a_start_elsewhere_and_samples_in_another_rhythm() -> None:
    gains = design_cascade(RUBBING.servo_axis(), times=SampleTimes(2e-4, 4e-4, 2e-3))
    found = hm.sim.simulate_axis(RUBBING, gains, np.full(200, -3.0), start=-3.0)
    assert np.abs(found.position + 3.0).max() < 2.0 * 2.0 * math.pi / 2000
    assert found.time[1] == 2e-3


def bad(gains: CascadeGains) -> CascadeGains:
    return dataclasses.replace(gains, times=SampleTimes(1e-4, 2.5e-4, 1e-3))


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        (lambda g: hm.sim.simulate_axis(PLAIN, g, np.zeros((2, 5))), ShapeError, r"shape \(2, 5\) came"),
        (
            lambda g: hm.sim.simulate_axis(PLAIN, g, [0.0, math.nan]),
            ShapeError,
            "nan came at sample 1; finite numbers are needed",
        ),
        (lambda g: hm.sim.simulate_axis(PLAIN, g, [0.0], load_torque=[0.0, 1.0]), ShapeError, r"shape \(2,\) came"),
        (lambda g: hm.sim.simulate_axis(PLAIN, g, [0.0], loop="torque"), OutOfLimits, "position, speed, current"),
        (lambda g: hm.sim.simulate_axis(PLAIN, bad(g), [0.0]), OutOfLimits, "must be a multiple of 0.0001 s"),
        (lambda g: Load(0.0), ModelError, "inertia is 0"),
        (lambda g: dataclasses.replace(PLAIN, gap=-1e-3), ModelError, "gap is -0.001"),
        (lambda g: dataclasses.replace(PLAIN, stiffness=0.0), ModelError, "stiffness is 0"),
    ],
)
def test_bad_input_is_named(call, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        call(design_cascade(PLAIN.servo_axis()))
