"""PMSM in dq coordinates: exact steps against a stiff solver, energy, limits, field orientation, six steps."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from holonom.devices import (
    Dq,
    FieldOrientation,
    Pmsm,
    SixStep,
    field_reference,
    hall_sector,
    pmsm_step,
    run_pmsm,
    six_step_step,
    six_step_torque,
)
from holonom.errors import ModelError, NotFinite, ShapeError

FLAT = Pmsm(0.232, 0.161e-3, 0.161e-3, 2.09167e-3, 8, 1.35e-5, 24.0, 20.0)


def case(data_folder: Path, start: str) -> dict[str, Any]:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text())
    return next(one for one in cases if one["id"].startswith(start))


def machine(seed: int) -> Pmsm:
    """A random interior-magnet motor whose current circle and voltage circle both matter."""
    rng = np.random.default_rng(seed)
    ld = 10 ** rng.uniform(-4, -2)
    current = rng.uniform(5.0, 20.0)
    return Pmsm(
        resistance=rng.uniform(0.1, 1.0), inductance_d=ld, inductance_q=ld * rng.uniform(1.0, 3.0),
        flux=ld * current * rng.uniform(0.8, 3.0), pole_pairs=int(rng.integers(1, 9)), rotor_inertia=1e-4,
        max_voltage=60.0, max_current=current,
    )  # fmt: skip


def slopes(m: Pmsm, i: np.ndarray, u: Dq, w: float) -> list[float]:
    """The voltage equations as the book has them."""
    return [
        (u.d - m.resistance * i[0] + w * m.inductance_q * i[1]) / m.inductance_d,
        (u.q - m.resistance * i[1] - w * (m.inductance_d * i[0] + m.flux)) / m.inductance_q,
    ]


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("speed", [0.0, -300.0, 900.0])
def test_a_step_is_that_of_a_stiff_solver(seed: int, speed: float) -> None:
    m = machine(seed)
    u, start, dt = Dq(-7.0, 11.0), Dq(2.0, -3.0), 1e-3
    w = m.pole_pairs * speed
    exact = solve_ivp(lambda _, i: slopes(m, i, u, w), (0.0, dt), start, method="Radau", rtol=1e-10, atol=1e-11)
    found = pmsm_step(m.params(), start, u, speed, dt)
    np.testing.assert_allclose(found, exact.y[:, -1], rtol=1e-7, atol=1e-7)
    half = pmsm_step(m.params(), start, u, speed, 0.5 * dt)
    np.testing.assert_allclose(pmsm_step(m.params(), half, u, speed, 0.5 * dt), found, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_a_very_long_step_settles(seed: int) -> None:
    m, u = machine(seed), Dq(1.0, 2.0)
    for speed in (0.0, 50.0, 2000.0):
        settled = m.voltage(pmsm_step(m.params(), Dq(5.0, 5.0), u, speed, 100.0), speed)
        np.testing.assert_allclose(settled, u, rtol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_power_goes_to_copper_field_and_shaft(seed: int) -> None:
    m, speed, u, steps, dt = machine(seed), 200.0, Dq(3.0, 20.0), 2000, 1e-6
    currents = [Dq(1.0, 2.0)]
    for _ in range(steps):
        currents.append(pmsm_step(m.params(), currents[-1], u, speed, dt))
    i = np.array(currents)

    def over_time(power: np.ndarray) -> float:
        return float(np.trapezoid(power, dx=dt))

    taken = over_time(1.5 * (u.d * i[:, 0] + u.q * i[:, 1]))
    copper = over_time(1.5 * m.resistance * np.sum(i * i, axis=1))
    shaft = speed * over_time(np.array([m.torque(Dq(*row)) for row in i]))
    field = 0.75 * (m.inductance_d * (i[-1, 0] ** 2 - i[0, 0] ** 2) + m.inductance_q * (i[-1, 1] ** 2 - i[0, 1] ** 2))
    assert taken == pytest.approx(copper + shaft + field, rel=1e-4, abs=1e-7)


def test_published_torque_per_ampere(data_folder: Path) -> None:
    found = case(data_folder, "maximum torque per ampere")
    g = found["input"]
    m = Pmsm(1.0, g["Ld"], g["Lq"], g["psi"], g["pole_pairs"], 1e-4, 300.0, 20.0)
    best = m.most_torque_per_ampere(g["current"])
    assert best.d == pytest.approx(found["expected"]["id"], rel=found["tol"])
    assert best.q == pytest.approx(found["expected"]["iq"], rel=found["tol"])
    assert m.torque(best) == pytest.approx(found["expected"]["torque"], rel=found["tol"])


def test_published_motor(data_folder: Path) -> None:
    found = case(data_folder, "PMSM p 8")
    g, expected = found["input"], found["expected"]
    psi = g["torque_constant_per_peak_A"] / (1.5 * g["pole_pairs"])
    m = Pmsm(g["R_phase"], g["L_phase"], g["L_phase"], psi, g["pole_pairs"], 1e-5, g["Udc"], 20.0)
    torque, speed = m.short_circuit_brake()
    values = (psi, m.no_load_speed, torque, speed)
    names = ("psi", "no_load_speed", "short_circuit_brake_peak_torque", "short_circuit_speed_of_peak")
    for name, value in zip(names, values, strict=True):
        assert value == pytest.approx(expected[name], rel=found["tol"]), name
    braking = pmsm_step(m.params(), Dq(0.0, 0.0), Dq(0.0, 0.0), speed, 1.0)
    assert m.torque(braking) == pytest.approx(-torque, rel=1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_torque_per_ampere_is_the_greatest_on_the_circle(seed: int) -> None:
    m = machine(seed)
    angles = np.linspace(0.0, 2.0 * math.pi, 20001)
    made = (
        1.5 * m.pole_pairs * (m.flux + (m.inductance_d - m.inductance_q) * 7.0 * np.cos(angles)) * 7.0 * np.sin(angles)
    )
    assert m.torque(m.most_torque_per_ampere(7.0)) == pytest.approx(made.max(), rel=1e-6)
    assert m.torque(m.most_torque_per_ampere(-7.0)) == pytest.approx(made.min(), rel=1e-6)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("part", [0.5, 1.3, 2.5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_references_use_what_the_limits_leave(seed: int, part: float, sign: float) -> None:
    """Beside the best of all currents of a fine grid within circle and voltage."""
    m = machine(seed)
    control = FieldOrientation(used=1.0).params(m)
    speed = part * m.no_load_speed
    d, q = np.meshgrid(np.linspace(-m.max_current, 0.0, 801), sign * np.linspace(0.0, m.max_current, 801))
    w = m.pole_pairs * speed
    u_d = m.resistance * d - w * m.inductance_q * q
    u_q = m.resistance * q + w * (m.inductance_d * d + m.flux)
    allowed = (d * d + q * q <= m.max_current**2) & (u_d**2 + u_q**2 <= m.phase_voltage**2)
    made = np.where(allowed, sign * 1.5 * m.pole_pairs * (m.flux + (m.inductance_d - m.inductance_q) * d) * q, 0.0)
    found = field_reference(control, sign * 1e3, speed)
    torque = sign * m.torque(found)
    assert torque >= 0.985 * made.max() - 1e-3
    voltage = m.voltage(found, speed)
    if allowed.any():
        assert math.hypot(voltage.d, voltage.q) <= m.phase_voltage * 1.001
    assert math.hypot(found.d, found.q) <= m.max_current * 1.000001
    if torque > 1e-3:
        less = field_reference(control, sign * 0.4 * torque, speed)
        assert m.torque(less) == pytest.approx(sign * 0.4 * torque, rel=1e-3)
        assert math.hypot(*less) <= math.hypot(*found) + 1e-9


def test_the_demagnetising_current_is_a_limit_of_its_own() -> None:
    m = machine(3)
    bound = 0.2 * m.max_current
    guarded = FieldOrientation().params(replace(m, demagnetising_current=bound))
    free = FieldOrientation().params(m)
    speed = 1.5 * m.no_load_speed
    assert field_reference(free, 5.0, speed).d < -bound
    assert field_reference(guarded, 5.0, speed).d >= -bound


@pytest.mark.parametrize("seed", range(4))
def test_the_drive_makes_its_torque_and_weakens_its_field(seed: int) -> None:
    m = machine(seed)
    control = FieldOrientation(sample=5e-5)
    wanted = 0.5 * m.torque(m.most_torque_per_ampere(m.max_current))
    run = run_pmsm(m, np.full(400, wanted), control=control, load_inertia=10.0)
    assert run.torque[-1] == pytest.approx(wanted, rel=5e-3)
    assert run.torque.max() < 1.05 * wanted
    speed = 1.2 * m.no_load_speed
    fast = run_pmsm(m, np.full(4000, 0.05 * wanted), control=control, load_inertia=1e3, speed=speed)
    assert fast.current[-1, 0] < 0.0
    assert np.all(np.hypot(*fast.voltage.T) <= m.phase_voltage * 1.000001)
    reference = m.torque(field_reference(control.params(m), 0.05 * wanted, speed))
    assert fast.torque[-1] == pytest.approx(reference, rel=0.02, abs=1e-4)


def test_the_whole_drive_is_that_of_a_stiff_solver() -> None:
    """The same voltages, motor and shaft integrated by Radau, speed coupled."""
    run = run_pmsm(FLAT, np.where(np.arange(300) < 150, 0.2, -0.1), 0.01, load_inertia=2e-5, viscous=1e-5)
    state = np.zeros(3)
    for k in range(300):
        u = Dq(*run.voltage[k])

        def rates(_: float, x: np.ndarray, u: Dq = u) -> list[float]:
            drive = FLAT.torque(Dq(x[0], x[1])) - 0.01 - 1e-5 * x[2]
            return [*slopes(FLAT, x[:2], u, 8 * x[2]), drive / 3.35e-5]

        state = solve_ivp(rates, (0.0, 1e-4), state, method="Radau", rtol=1e-8, atol=1e-9).y[:, -1]
        if k == 149:
            assert run.speed[k] == pytest.approx(state[2], rel=2e-3)
    assert run.speed[-1] == pytest.approx(state[2], rel=5e-3)


def test_published_six_steps(data_folder: Path) -> None:
    found = case(data_folder, "six-step")
    assert SixStep().mean_over_peak == pytest.approx(found["expected"]["mean_over_peak"], abs=found["tol"])
    assert SixStep().ripple_over_mean == pytest.approx(found["expected"]["ripple_pp_over_mean"], abs=found["tol"])


def trapezoid(x: float) -> float:
    """Back-emf of a phase, flat over 120 degrees, x from the middle of its top."""
    return float(np.interp(math.remainder(x, 2.0 * math.pi), np.radians([-180, -120, -60, 60, 120, 180]),
                           [-1.0, -1.0, 1.0, 1.0, -1.0, -1.0]))  # fmt: skip


@pytest.mark.parametrize("offset", [0.0, 0.3, -0.9, 1.4, 2.5])
def test_trapezoidal_back_emf_by_its_phases(offset: float) -> None:
    six = SixStep(offset, "trapezoid")
    params = six.params(FLAT)
    assert params.constant == pytest.approx(2.0 * FLAT.pole_pairs * FLAT.flux)
    angles = (np.arange(3600) + 0.5) * 2.0 * math.pi / 3600 / FLAT.pole_pairs
    made = np.array([six_step_torque(params, angle) for angle in angles]) / params.constant
    for angle, torque in zip(angles[::50], made[::50], strict=True):
        top = (hall_sector(params, angle) + 0.5) * math.pi / 3.0  # where the two phases are both on their tops
        x = FLAT.pole_pairs * angle - top
        pair = 0.5 * (trapezoid(x - math.pi / 6.0) - trapezoid(x - math.pi / 6.0 - 2.0 * math.pi / 3.0))
        assert torque == pytest.approx(pair, abs=1e-9)
    assert made.mean() == pytest.approx(six.mean_over_peak, abs=1e-3)
    assert np.ptp(made) / abs(made.mean()) == pytest.approx(six.ripple_over_mean, rel=2e-2, abs=1e-9)


@pytest.mark.parametrize("offset", [0.0, 0.2, -0.7, 1.2])
def test_six_steps_by_integration(offset: float) -> None:
    six = SixStep(offset)
    params = six.params(FLAT)
    angles = np.linspace(0.0, 2.0 * math.pi, 60000, endpoint=False)
    made = np.array([six_step_torque(params, angle) for angle in angles])
    assert made.mean() / params.constant == pytest.approx(six.mean_over_peak, abs=1e-4)
    assert np.ptp(made) / made.mean() == pytest.approx(six.ripple_over_mean, rel=1e-2)
    assert {hall_sector(params, angle) for angle in angles} == set(range(6))
    smooth = quad(lambda x: math.cos(x), offset - math.pi / 6, offset + math.pi / 6)[0] / (math.pi / 3)
    assert six.mean_over_peak == pytest.approx(smooth)
    current = 0.0
    for _ in range(400):
        current = six_step_step(params, current, 12.0, 0.1, 50.0, 1e-4)
    assert current == pytest.approx((12.0 - 50.0 * six_step_torque(params, 0.1)) / (2 * 0.232))


def test_six_step_characteristic_ends_at_the_no_load_speed() -> None:
    six = SixStep()
    k = six.params(FLAT).constant * six.mean_over_peak
    assert six.torque(FLAT, 24.0 / k) == pytest.approx(0.0, abs=1e-9)
    assert six.torque(FLAT, 0.0) == pytest.approx(k * 20.0)


def test_bad_input_is_refused() -> None:
    for name, value in (("resistance", 0.0), ("flux", -1.0), ("rotor_inertia", math.nan), ("pole_pairs", 0)):
        with pytest.raises(ModelError, match=name):
            replace(FLAT, **{name: value})
    with pytest.raises(ModelError, match="modulation"):
        replace(FLAT, modulation="square")
    with pytest.raises(ShapeError, match="torque"):
        run_pmsm(FLAT, 1.0)
    with pytest.raises(ShapeError, match="load"):
        run_pmsm(FLAT, [1.0, 2.0], [1.0, 2.0, 3.0])
    with pytest.raises(NotFinite):
        run_pmsm(FLAT, [1.0, math.nan])
    with pytest.raises(ModelError, match="speed_up"):
        FieldOrientation(speed_up=0.5)
