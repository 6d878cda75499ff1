"""What motors, grip and tipping allow a base along each axis, against Newton's law written out here, and the plant."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.devices import DcMotor, Encoder, Gear
from holonom.mobile import BaseDrive, ackermann, differential, mecanum, skid_steer, swerve
from holonom.mobile.drive.abilities import abilities


def drive_of(rng: np.random.Generator) -> BaseDrive:
    motor = DcMotor(
        resistance=1.2, inductance=0.5e-3, torque_constant=0.03, back_emf_constant=0.03, rotor_inertia=1e-5,
        max_voltage=12.0, max_current=float(rng.uniform(0.5, 8.0)),
    )  # fmt: skip
    return BaseDrive(
        motor, Gear(float(rng.uniform(5.0, 20.0))), Encoder(4096), wheel_inertia=float(rng.uniform(1e-5, 2e-3))
    )


def test_a_differential_drive_against_newton() -> None:
    """Forwards two wheels share the mass; in turning they push at half a track; each turns its own inertia, too."""
    for seed in range(30):
        rng = np.random.default_rng(seed)
        drive, m, r, track, mu = (
            drive_of(rng),
            rng.uniform(3.0, 30.0),
            0.05,
            rng.uniform(0.2, 0.5),
            rng.uniform(0.1, 0.9),
        )
        base = differential(track, r, mass=m, com=(-0.2 * track, 0.0), com_height=0.05, castor=(-track, 0.0))
        found = abilities(base, drive, mu)
        motor, N = drive.motor, drive.gear.ratio
        push = motor.torque_constant * min(motor.max_current, motor.max_voltage / motor.resistance) * N / r
        own = (drive.wheel_inertia + N**2 * motor.rotor_inertia) / r**2
        grip = mu * 0.5 * m * 9.80665 * 0.8  # the castor carries a fifth
        by_tipping = 9.80665 * 0.2 * track / 0.05, 9.80665 * 0.8 * track / 0.05
        a = min(push / (0.5 * m + own), grip / (0.5 * m), *by_tipping)
        assert found["forwards"].acceleration == pytest.approx(a, rel=1e-3)
        assert found["forwards"].speed == pytest.approx(motor.no_load_speed * r / N)
        about = base.alpha * m * base.radius**2 + m * (0.2 * track) ** 2  # about the middle of the axle
        f = about / track
        assert found["turning"].acceleration == pytest.approx(min(push / (f + own * track / 2), grip / f), rel=1e-3)
        assert found["turning"].speed == pytest.approx(motor.no_load_speed * r / N / (track / 2))
        assert found["sideways"] == (math.inf, math.inf)


def test_what_is_no_motion_alone_is_left_open() -> None:
    drive = drive_of(np.random.default_rng(0))
    body = {"mass": 8.0, "com_height": 0.05}
    car = abilities(ackermann(0.4, 0.3, 0.05, max_steering=0.8, com=(0.2, 0.0), **body), drive, 0.6)
    assert car["turning"] == car["sideways"] == (math.inf, math.inf)
    assert math.isfinite(car["forwards"].acceleration)
    assert abilities(skid_steer(0.3, 0.4, 0.05, **body), drive, 0.6)["turning"] == (math.inf, math.inf)
    for base in (mecanum(0.4, 0.3, 0.05, **body), swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05, **body)):
        assert all(0.0 < a < math.inf and 0.0 < v < math.inf for v, a in abilities(base, drive, 0.6).values())
