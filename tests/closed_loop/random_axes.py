"""Random axes with real motors, and what they truly are beside their sheets."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.sim import Axis, Load

MOTORS = [  # R, L, k, J, U, nominal current: maxon RE 40 (48 V, 24 V), RE 25, EC 45, A-max 32; Puma 560's
    (1.13, 0.33e-3, 0.0603, 1.37e-5, 48.0, 3.17),
    (0.316, 0.08e-3, 0.0302, 1.34e-5, 24.0, 6.0),
    (2.32, 0.24e-3, 0.0234, 1.1e-6, 24.0, 1.2),
    (0.464, 0.322e-3, 0.0251, 1.35e-5, 24.0, 2.3),
    (3.99, 0.556e-3, 0.0352, 4.53e-6, 24.0, 0.9),
    (2.1, 4.9e-3, 0.189, 2e-4, 40.0, 5.0),
    (6.7, 10e-3, 0.066, 3.3e-5, 40.0, 2.0),
]


def random_axis(rng: np.random.Generator) -> tuple[Axis, Axis]:
    """An axis by its sheets, and the one that it is, as far off as it may be after a self-check."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    R, L, k, J, U, nominal = MOTORS[rng.integers(len(MOTORS))]
    ratio, friction = between(1.0, 100.0), k * nominal * between(0.002, 0.1)
    lines = between(max(100.0, 0.25 * 2.0 * math.pi / (5e-4 * 0.02 * U / k)), 5000.0)  # a count in a look: 2 % of top
    axis = Axis(
        DcMotor(R, L, k, k, J, U, nominal * between(1.5, 4.0)),
        Load(
            J * between(0.3, 10.0) * ratio**2,
            coulomb=friction * ratio * rng.uniform(0.0, 0.5),
            viscous=0.3 * k * nominal / (U / k) * rng.uniform() * ratio**2,
        ),
        Encoder(4 * int(lines)),
        Gear(ratio, rng.uniform(0.7, 1.0)),
        Friction(0.0, friction, friction * rng.uniform(0.5, 1.5)),
        gap=float(rng.choice([0.0, rng.uniform(0.0, 0.02)])) / ratio,
    )
    true = dataclasses.replace(
        axis.motor,
        resistance=R * rng.uniform(0.98, 1.02),
        inductance=L * rng.uniform(0.9, 1.1),
        torque_constant=k * rng.uniform(0.97, 1.03),
        back_emf_constant=k * rng.uniform(0.97, 1.03),
    )
    return axis, dataclasses.replace(axis, motor=true)


def top_speed(axis: Axis) -> float:
    """No-load speed at the joint, rad/s."""
    return axis.motor.max_voltage / axis.motor.back_emf_constant / axis.gear.ratio


def torque(axis: Axis, part: float) -> float:
    """Part of the greatest torque at the joint, N m."""
    return part * axis.motor.torque_constant * axis.motor.max_current * axis.gear.ratio * axis.gear.efficiency


def ramp(speed: float, seconds: float, samples: int) -> np.ndarray:
    """Up to a speed in so many seconds, a sample each millisecond."""
    return np.minimum(np.arange(samples) * 1e-3 / seconds, 1.0) * speed
