"""Stepping, induction, reluctance motors and cogging: published values, energy, independent solutions."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from holonom.devices import (
    AngleTable,
    Cogging,
    DcMotor,
    InductionMachine,
    InductionMotor,
    InductionState,
    Stepper,
    SwitchedReluctance,
    check_angles,
    cogging_torque,
    induction_step,
    reluctance_step,
    reluctance_torque,
    run_reluctance,
    run_stepper,
)
from holonom.errors import ModelError, NotFinite, OutOfLimits, ShapeError


def case(data_folder: Path, start: str) -> dict[str, Any]:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text())
    return next(one for one in cases if one["id"].startswith(start))


NEMA17 = Stepper(0.4, 50, 1.04e-5)


def test_published_stepper(data_folder: Path) -> None:
    found = case(data_folder, "stepper")
    g = found["input"]
    motor = Stepper(g["holding_torque"], g["rotor_teeth"], g["inertia"])
    assert motor.steps_per_turn == g["steps_per_turn"]
    values = {
        "natural_frequency_Hz": motor.natural_frequency,
        "deflection_full_steps": motor.deflection(g["load"]),
        "torque_of_one_sixteenth_step": motor.microstep_torque(16),
        "lost_steps_multiple_of": motor.lost_steps_multiple_of,
    }
    assert values == pytest.approx(found["expected"], rel=found["tol"])


def swing(motor: Stepper, rates: np.ndarray, load: float = 0.0, dt: float = 2e-5) -> np.ndarray:
    """Angles while the command turns at `rates` (rad/s of the shaft), one each step."""
    return run_stepper(motor, dt * np.cumsum(rates), load, dt=dt).angle


def test_a_small_swing_has_the_natural_frequency_and_keeps_its_energy() -> None:
    angles = run_stepper(NEMA17, np.zeros(20000), dt=2e-5, angle=1e-4).angle
    rising = np.flatnonzero((angles[:-1] < 0.0) & (angles[1:] >= 0.0))
    frequency = (rising.size - 1) / ((rising[-1] - rising[0]) * 2e-5)
    assert frequency == pytest.approx(NEMA17.natural_frequency, rel=2e-3)
    assert max(np.abs(angles[-500:])) == pytest.approx(1e-4, rel=2e-3)


@pytest.mark.parametrize("load", [0.1, -0.3])
def test_a_load_bends_the_rotor_by_its_deflection(load: float) -> None:
    angles = swing(replace(NEMA17, viscous=5e-3), np.zeros(20000), load)
    assert -angles[-1] / NEMA17.full_step == pytest.approx(NEMA17.deflection(load), rel=1e-4)


def test_steps_are_lost_in_fours_under_overload_and_at_resonance() -> None:
    damped = replace(NEMA17, viscous=2e-3)
    pushed = np.where(np.arange(30000) < 15000, 0.6, 0.0)
    run = run_stepper(damped, np.zeros(30000), pushed, dt=2e-5)
    assert run.lost_steps > 0
    assert run.lost_steps % 4 == 0
    assert run.speed[-1] == pytest.approx(0.0, abs=1e-3)
    held = run_stepper(damped, np.zeros(30000), 0.5 * pushed, dt=2e-5)
    assert held.lost_steps == 0
    fast = 1e-3 * np.arange(30000)  # 50 rad/s at once: the rotor cannot follow
    assert run_stepper(damped, fast, 0.05, dt=2e-5).lost_steps > 100

    def stepped(rate: float) -> float:
        """Largest swing about the command while full steps come at `rate` (Hz)."""
        command = np.floor(rate * 2e-5 * np.arange(15000)) * NEMA17.full_step
        run = run_stepper(replace(NEMA17, viscous=2e-4), command, dt=2e-5)
        return float(np.abs(run.angle - command).max())

    slow, resonant = stepped(15.0), stepped(NEMA17.natural_frequency / 2.0)
    assert resonant > 1.2 * slow


def test_stepper_torque_falls_with_speed() -> None:
    speeds = np.linspace(0.0, 400.0, 200)
    torques = [NEMA17.pull_out_torque(w) for w in speeds]
    assert torques[0] == 0.4
    assert np.all(np.diff(torques) <= 1e-12)
    assert torques[-1] < 0.25
    # beside the greatest torque over all load angles of a synchronous machine
    w, k, z = 300.0, 0.4, 1.0 + 1j * 50 * 300.0 * 2e-3
    currents = (24.0 * np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 3601)) - w * k) / z
    assert NEMA17.pull_out_torque(w) == pytest.approx(k * currents.real.max(), rel=1e-5)


def test_microsteps_turn_the_field_evenly() -> None:
    for step in np.linspace(-8.0, 8.0, 129):
        a, b = NEMA17.currents(step)
        assert math.hypot(a, b) == pytest.approx(1.0)
        assert math.remainder(math.atan2(b, a) - 0.5 * math.pi * step, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(OutOfLimits, match="loses steps"):
        NEMA17.deflection(0.5)
    with pytest.raises(ModelError, match="rotor_teeth"):
        replace(NEMA17, rotor_teeth=0)


def test_published_kloss(data_folder: Path) -> None:
    found = case(data_folder, "induction motor")
    g = found["input"]
    motor = InductionMotor(g["breakdown_torque"], g["breakdown_slip"], g["synchronous_rpm"] * math.pi / 30.0)
    assert motor.starting_torque == pytest.approx(found["expected"]["starting_torque"], rel=found["tol"])
    assert motor.torque_at_slip(0.03) == pytest.approx(found["expected"]["torque_at_3_percent_slip"], rel=found["tol"])
    slips = np.linspace(1e-3, 2.0, 20000)
    assert slips[np.argmax([motor.torque_at_slip(s) for s in slips])] == pytest.approx(0.2, abs=1e-3)
    assert motor.torque_at_slip(-0.1) == -motor.torque_at_slip(0.1)
    assert motor.torque(motor.synchronous_speed) == 0.0


def induction(seed: int) -> InductionMachine:
    rng = np.random.default_rng(seed)
    lm = rng.uniform(0.05, 0.3)
    leak = rng.uniform(0.03, 0.1, 2) * lm
    return InductionMachine(*rng.uniform(0.3, 2.0, 2), lm + leak[0], lm + leak[1], lm, int(rng.integers(1, 4)))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("slip", [0.05, 0.6, -0.1])
def test_without_stator_resistance_the_machine_is_kloss(seed: int, slip: float) -> None:
    machine = replace(induction(seed), stator_resistance=1e-9)
    kloss = machine.kloss(300.0, 50.0)
    speed = (1.0 - slip) * kloss.synchronous_speed
    assert machine.torque(300.0, 50.0, speed) == pytest.approx(kloss.torque(speed), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_running_machine_settles_at_its_steady_torque(seed: int) -> None:
    machine = induction(seed)
    speed, dt, w = 0.9 * 2.0 * math.pi * 50.0 / machine.pole_pairs, 5e-5, 2.0 * math.pi * 50.0
    state, torque, params = InductionState(0j, 0j), 0.0, machine.params()
    for k in range(40000):
        voltage = 300.0 * complex(math.cos(w * (k + 0.5) * dt), math.sin(w * (k + 0.5) * dt))
        state, torque = induction_step(params, state, voltage, speed, dt)
    assert torque == pytest.approx(machine.torque(300.0, 50.0, speed), rel=2e-3)


@pytest.mark.parametrize("seed", range(6))
def test_a_step_of_the_machine_is_that_of_a_stiff_solver(seed: int) -> None:
    m, speed, u, dt = induction(seed), 80.0, 100.0 - 40.0j, 2e-3
    start = InductionState(0.3 + 0.1j, -0.2 + 0.4j)
    spread = m.stator_inductance * m.rotor_inductance - m.magnetising_inductance**2

    def rates(_: float, x: np.ndarray) -> list[float]:
        s, r = complex(x[0], x[1]), complex(x[2], x[3])
        i_s = (m.rotor_inductance * s - m.magnetising_inductance * r) / spread
        i_r = (m.stator_inductance * r - m.magnetising_inductance * s) / spread
        ds = u - m.stator_resistance * i_s
        dr = 1j * m.pole_pairs * speed * r - m.rotor_resistance * i_r
        return [ds.real, ds.imag, dr.real, dr.imag]

    first = [start.stator.real, start.stator.imag, start.rotor.real, start.rotor.imag]
    exact = solve_ivp(rates, (0.0, dt), first, method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    found, _ = induction_step(m.params(), start, u, speed, dt)
    np.testing.assert_allclose(
        [found.stator.real, found.stator.imag, found.rotor.real, found.rotor.imag], exact, rtol=1e-7, atol=1e-9
    )


@pytest.mark.parametrize("seed", range(4))
def test_power_of_the_machine_goes_to_copper_field_and_shaft(seed: int) -> None:
    m, speed, dt = induction(seed), 60.0, 2e-6
    spread = m.stator_inductance * m.rotor_inductance - m.magnetising_inductance**2
    state, balance, made, before = InductionState(0.2 + 0j, 0.1j), 0.0, [], 0.0
    for k in range(2001):
        i_s = (m.rotor_inductance * state.stator - m.magnetising_inductance * state.rotor) / spread
        i_r = (m.stator_inductance * state.rotor - m.magnetising_inductance * state.stator) / spread
        field = 0.75 * ((state.stator.conjugate() * i_s).real + (state.rotor.conjugate() * i_r).real)
        torque = 1.5 * m.pole_pairs * (state.stator.conjugate() * i_s).imag
        copper = 1.5 * (m.stator_resistance * abs(i_s) ** 2 + m.rotor_resistance * abs(i_r) ** 2)
        made.append(1.5 * (150.0 * i_s.conjugate()).real - copper - torque * speed)
        if k == 0:
            before = field
        balance = field - before
        state, _ = induction_step(m.params(), state, 150.0 + 0j, speed, dt)
    assert np.trapezoid(made, dx=dt) == pytest.approx(balance, rel=1e-4)


def test_a_magnetising_inductance_below_its_coils() -> None:
    with pytest.raises(ModelError, match="magnetising_inductance"):
        replace(induction(0), magnetising_inductance=1.0)
    with pytest.raises(ModelError, match="breakdown_slip"):
        InductionMotor(1.0, 0.0, 100.0)


SRM = SwitchedReluctance(0.5, 2e-3, 10e-3, 4, 3, 48.0, 10.0)


@pytest.mark.parametrize("x", [0.4, 1.5, 3.0, 4.5])
def test_reluctance_torque_is_the_slope_of_the_coenergy(x: float) -> None:
    p = SRM.params()

    def coenergy(angle: float) -> float:
        return 0.5 * 7.0**2 * (6e-3 - 4e-3 * math.cos(4.0 * angle))

    slope = (coenergy(x / 4.0 + 1e-6) - coenergy(x / 4.0 - 1e-6)) / 2e-6
    assert reluctance_torque(p, 7.0, x) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("speed", [60.0, 300.0])
@pytest.mark.parametrize("seed", range(3))
def test_a_cycle_turns_electric_energy_into_copper_and_shaft(seed: int, speed: float) -> None:
    """Own integration of the third period, finer, by Euler's rule with a hysteresis chopper, of random machines."""
    rng = np.random.default_rng(seed)
    R, low, ratio, poles = (
        rng.uniform(0.2, 1.0),
        rng.uniform(1e-3, 3e-3),
        rng.uniform(3.0, 8.0),
        int(rng.integers(2, 8)),
    )
    motor = SwitchedReluctance(R, low, ratio * low, poles, 3, 48.0, 10.0)
    mean, swing = 0.5 * low * (ratio + 1.0), 0.5 * low * (ratio - 1.0)
    on, off = motor.best_angles(speed, 8.0)
    steps = 12000
    dx = 2.0 * math.pi / steps
    dt = dx / (poles * speed)
    flux, taken, copper, shaft, began = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(3 * steps):
        if k == 2 * steps:
            taken, copper, shaft, began = 0.0, 0.0, 0.0, flux
        x = -0.5 * math.pi + (k + 0.5) * dx
        current = flux / (mean - swing * math.cos(x))
        inside = (x - on) % (2.0 * math.pi) < off - on
        voltage = (48.0 if current < 8.0 else -48.0) if inside else (-48.0 if flux > 0.0 else 0.0)
        taken += voltage * current * dt
        copper += R * current**2 * dt
        shaft += 0.5 * current**2 * poles * swing * math.sin(x) * speed * dt
        flux = max(flux + dt * (voltage - R * current), 0.0)
    assert flux == pytest.approx(began, abs=2e-3)
    assert taken == pytest.approx(copper + shaft, rel=0.06)
    found = motor.cycle((on, off), speed, 8.0)
    period = 2.0 * math.pi / (poles * speed)
    assert found.torque == pytest.approx(3.0 * shaft / speed / period, rel=0.02)
    assert found.rms == pytest.approx(math.sqrt(copper / R / period), rel=0.02)
    assert reluctance_step(motor.params(), 0.0, -48.0, 1.0, 1e-4) == 0.0


@pytest.fixture(scope="module")
def angles() -> AngleTable:
    return SRM.angle_table([5.0, 60.0, 200.0], [4.0, 9.0])


def test_angles_lead_with_speed_and_current_in_four_quadrants(angles: AngleTable) -> None:
    on, off = angles.driving[:, 1, 0], angles.driving[:, 1, 1]
    assert on[2] < on[0]
    assert off[2] < off[0] + 0.05
    for speed in (60.0, -60.0):
        assert SRM.cycle(angles.angles(speed, 9.0), speed, 9.0).torque > 0.5
        assert SRM.cycle(angles.angles(speed, 9.0, braking=True), speed, 9.0).torque < -0.5
    assert SRM.torque(400.0) < SRM.torque(5.0)
    assert SRM.cycle(angles.angles(5.0, 9.0), 5.0, 9.0).peak < 9.0001


def test_a_right_table_is_silent_and_a_wrong_one_is_named(angles: AngleTable) -> None:
    assert check_angles(SRM, angles) == ()

    def first(table: AngleTable, motor: SwitchedReluctance = SRM) -> str:
        return check_angles(motor, table)[0].name

    assert "on and off exchanged" in first(replace(angles, driving=angles.driving[:, :, ::-1]))
    assert "degrees read as rad" in first(replace(angles, driving=np.degrees(angles.driving)))
    assert "of the shaft" in first(replace(angles, driving=angles.driving / 4.0))
    assert "driving and braking exchanged" in first(replace(angles, driving=angles.braking, braking=angles.driving))
    assert "turned by -40 electrical degrees" in first(replace(angles, driving=angles.driving - np.radians(40.0)))
    turned = check_angles(replace(SRM, sensor_offset=np.radians(40.0)), angles)
    assert "turned by -40 electrical degrees" in turned[0].name


def test_a_coarse_sensor_costs_torque() -> None:
    fine = SRM.cycle(SRM.best_angles(60.0, 8.0), 60.0, 8.0).torque
    hall = replace(SRM, sensor="hall")
    assert hall.resolution == pytest.approx(math.pi / 3.0)
    assert 0.3 * fine < hall.cycle(SRM.best_angles(60.0, 8.0), 60.0, 8.0).torque < fine
    assert replace(SRM, sensor_steps=360).cycle(SRM.best_angles(60.0, 8.0), 60.0, 8.0).torque > 0.97 * fine


@pytest.mark.parametrize("speed", [60.0, -60.0])
@pytest.mark.parametrize("asked", [8.0, -8.0])
def test_all_four_quadrants_at_a_held_speed(angles: AngleTable, speed: float, asked: float) -> None:
    """A heavy shaft: the mean torque is that of the settled period, whatever the direction."""
    run = run_reluctance(SRM, angles, np.full(20000, asked), inertia=1e4, dt=2e-5, speed=speed)
    braking = asked * speed < 0.0
    cycle = SRM.cycle(angles.angles(speed, 8.0, braking=braking), speed, 8.0)
    assert run.torque[5000:].mean() == pytest.approx(math.copysign(cycle.torque, asked), rel=0.03)
    assert run.current.max() <= 8.0 * 1.05


@pytest.mark.parametrize("sensor", ["optical", "hall"])
def test_it_starts_brakes_and_turns_back(angles: AngleTable, sensor: str) -> None:
    asked = np.where(np.arange(60000) < 20000, 8.0, -8.0)
    motor = replace(SRM, sensor=sensor)
    run = run_reluctance(motor, angles, asked, inertia=5e-3, dt=2e-5)
    assert run.speed[19999] > 10.0
    assert run.speed[-1] < -5.0
    turned = run_reluctance(replace(motor, sensor_offset=math.pi), angles, asked[:20000], inertia=5e-3, dt=2e-5)
    assert turned.speed[-1] < 0.5 * run.speed[19999]


def test_wrong_tables_and_motors_are_refused(angles: AngleTable) -> None:
    with pytest.raises(ModelError, match="must grow"):
        replace(angles, speeds=np.array([3.0, 2.0, 1.0]))
    with pytest.raises(ModelError, match="aligned_inductance"):
        replace(SRM, aligned_inductance=1e-3)
    with pytest.raises(OutOfLimits, match="no switching angles"):
        SRM.best_angles(10.0, 0.0)
    with pytest.raises(ShapeError, match="load"):
        run_reluctance(SRM, angles, [1.0, 2.0], [1.0], inertia=1.0, dt=1e-4)
    with pytest.raises(ModelError, match="inertia"):
        run_reluctance(SRM, angles, [1.0], inertia=0.0, dt=1e-4)
    with pytest.raises(ModelError, match="dt"):
        run_stepper(NEMA17, [0.0], dt=1e-2)
    with pytest.raises(NotFinite):
        run_stepper(NEMA17, [math.nan], dt=1e-5)
    with pytest.raises(ModelError, match="speed"):
        SRM.cycle((0.0, 1.0), 0.0, 1.0)


def test_cogging_is_the_slope_of_an_energy_and_makes_a_dead_band() -> None:
    slots = Cogging(0.01, 12, 8)
    assert slots.periods == 24
    for angle in np.linspace(-1.0, 1.0, 41):
        slope = (slots.energy(angle + 1e-6) - slots.energy(angle - 1e-6)) / 2e-6
        assert cogging_torque(slots.params(), angle) == pytest.approx(-slope, abs=1e-8)
    motor = DcMotor(2.1, 4.9e-3, 0.189, 0.189, 2e-4, 40.0, 8.25)
    dead = slots.dead_band(motor, friction=0.005)

    def creeps(current: float) -> bool:
        """Whether a motor with much friction leaves its place of rest: force balance, quasi-statically."""
        angle = 0.0
        for _ in range(4000):
            push = 0.189 * current + cogging_torque(slots.params(), angle)
            angle += max(push - 0.005, 0.0)
        return angle > 2.0 * math.pi / 24

    assert not creeps(0.98 * dead.current)
    assert creeps(1.05 * dead.current)
    assert dead.voltage == pytest.approx(2.1 * dead.current)
    with pytest.raises(ModelError, match="even"):
        Cogging(0.01, 12, 7)
