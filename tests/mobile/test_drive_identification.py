"""kS, kV, kA of a wheel's drive from a ramp and a step: within 2 %, with honest errors, or a refusal that says why."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.app.about.drive_bench.bases import BASES
from holonom.closed_loop import simulate_base
from holonom.errors import CalibrationError, OutOfLimits, ShapeError
from holonom.machine import PATHS, PathLimits, plan_path
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.drive.identification import MotorConstants, identify_drive, mechanics_of
from holonom.mobile.drive.sized import sized_base_drive

TICKS = 4096


def driven(k: np.ndarray, *, dt: float = 0.01, kind: str = "both") -> tuple[np.ndarray, ...]:
    """Time, voltage, angle and speed: `kA wd = V - kS sign(w) - kV w` with stiction, exact while it turns one way."""
    t = np.arange(0.0, 14.0, dt)
    V = np.where(t < 6.0, 0.8 * t, 0.0)
    V[(t >= 7.0) & (t < 9.0)], V[(t >= 10.0) & (t < 12.0)] = 5.0, -4.0
    V = {"both": V, "steady": np.where(t < 0.01, 0.0, 5.0), "still": np.clip(V, -0.5 * k[0], 0.5 * k[0])}[kind]
    if kind == "steady":
        t, V = t[700:] - t[700], V[700:]
    w, phi, rows, fine = (V[0] - k[0]) / k[1] if kind == "steady" else 0.0, 0.0, [], 50
    for v in V:
        rows.append((phi, w))
        for _ in range(fine):
            sign = np.sign(w) if w != 0.0 else np.sign(v) * (abs(v) > k[0])
            if sign == 0.0:
                continue
            final, decay = (v - k[0] * sign) / k[1], np.exp(-dt / fine * k[1] / k[2])
            new = final + (w - final) * decay
            new = 0.0 if new * sign < 0.0 else new
            phi += final * dt / fine + (w - final) * (1.0 - decay) * k[2] / k[1] if new else 0.0
            w = new
    phi, w = np.array(rows).T
    return t, V, phi, w


def test_constants_from_ticks_and_from_noisy_speeds_and_how_sure() -> None:
    """Sixty motors: all within 2 % by an encoder; errors as large as they are said to be."""
    by_angle, by_speed = [], []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        k = rng.uniform(0.7, 1.3, 3) * [0.6, 0.9, 0.15]
        t, V, phi, w = driven(k)
        unit = 2.0 * np.pi / TICKS
        ticks = identify_drive(t, V, angle=unit * np.floor(phi / unit + rng.random()))
        found = np.array([ticks.kS.value, ticks.kV.value, ticks.kA.value])
        assert found == pytest.approx(k, rel=0.02)
        by_angle.append((found - k) / [ticks.kS.sigma, ticks.kV.sigma, ticks.kA.sigma])
        noisy = identify_drive(t, V, speed=w + 0.05 * rng.normal(size=len(w)))
        by_speed.append([(e.value - v) / e.sigma for e, v in zip((noisy.kS, noisy.kV, noisy.kA), k, strict=True)])
    for normal in (np.array(by_speed), np.array(by_angle)):
        assert np.all((normal.std(0) > 0.6) & (normal.std(0) < 1.6))
    inside = np.abs(by_speed) < 2.0
    assert 0.85 < inside.mean() < 0.995


def test_on_the_floor_two_deviations_hold_the_truth() -> None:
    """Bases on an eight without friction: kS is 0, kV the data sheet's back EMF; wheels push each other, and creep."""
    inside = []
    for name in ("differential", "ackermann", "mecanum", "omni", "dual_ackermann"):
        base = BASES[name]()
        drive = sized_base_drive(base, 2.0, 2.0)
        heading = "fixed" if moves_sideways(base) else "tangent"
        path = plan_path(PATHS.make("figure_of_eight", {"size": 4.0}), PathLimits(1.0, 1.0), heading=heading)
        log = simulate_base(base, drive, path, rng=np.random.default_rng(2))
        back_emf = drive.motor.back_emf_constant * drive.gear.ratio
        unit = 2.0 * np.pi / drive.encoder.counts_per_rev / drive.gear.ratio
        for k in range(len(base.driven)):
            angle = unit * np.floor(log.wheel_angles[:, k] / unit)
            found = identify_drive(log.time, log.voltages[:, k], angle=angle, loaded=True)
            inside += [
                abs(found.kS.value) < 2.0 * found.kS.sigma,
                abs(found.kV.value - back_emf) < 2.0 * found.kV.sigma,
            ]
    assert np.mean(inside) >= 0.95


def test_inertia_and_friction_by_the_data_sheet() -> None:
    """`V = R i + k N w`, `k N i = J wd + b w + c sign w`: a motor whose mechanics are known gives them back."""
    motor = MotorConstants(resistance=2.0, torque_constant=0.02, gear=20.0)
    J, b, c, per = 0.01, 0.03, 0.1, 0.02 * 20.0 / 2.0
    k = np.array([c / per, b / per + 0.4, J / per])
    t, V, phi, _ = driven(k)
    told = mechanics_of(identify_drive(t, V, angle=phi), motor)
    for name, value in (("inertia", J), ("viscous_friction", b), ("static_friction", c)):
        assert told[name].value == pytest.approx(value, rel=0.02)
        assert 0.0 < told[name].sigma < 0.1 * value


def test_logs_without_excitation_and_wrong_ones() -> None:
    k = np.array([0.6, 0.9, 0.15])
    t, V, phi, w = driven(k)
    still, steady = driven(k, kind="still"), driven(k, kind="steady")
    for call, problem, match in (
        (lambda: identify_drive(*still[:2], angle=still[2]), CalibrationError, "never turns: record a slow ramp"),
        (
            lambda: identify_drive(*steady[:2], angle=steady[2]),
            CalibrationError,
            "does not tell .*: record a slow ramp",
        ),
        (
            lambda: identify_drive(t[:60], V[700:760], speed=w[700:760]),
            CalibrationError,
            "windows of 0.4 s, 6 are needed",
        ),
        (lambda: identify_drive(t, V), CalibrationError, "either the wheel's angle or its speed"),
        (lambda: identify_drive(t, V, angle=phi, speed=w), CalibrationError, "either the wheel's angle or its speed"),
        (lambda: identify_drive(t, V[:-1], angle=phi), ShapeError, "give as many of each"),
        (lambda: identify_drive(t[::-1], V, angle=phi), ShapeError, "time that grows"),
        (lambda: identify_drive(t, np.full_like(V, np.nan), angle=phi), ShapeError, "voltage has shape"),
        (lambda: MotorConstants(0.0, 0.1), OutOfLimits, "resistance 0.0 came"),
    ):
        with pytest.raises(problem, match=match):
            call()
