"""Six-step (block) commutation of a brushless motor by three Hall sensors (spec 03.1).

Two phases conduct at a time, the current enters one and leaves another; every 60 electrical degrees it moves on. With
sinusoidal back-emf the torque is `sqrt 3 p psi I cos(x)`, x from -30 to 30 degrees: mean `3/pi` of the peak, ripple
`1 - cos 30` of it. With a trapezoidal one, flat over 120 degrees, it is `2 p psi I`, without ripple. Hanselman,
Brushless Permanent Magnet Motor Design, 2nd ed. 2003, ch. 8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.devices.motors.pmsm import Pmsm
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["SixStep", "SixStepParams", "hall_sector", "six_step_step", "six_step_torque"]

SECTOR = math.pi / 3.0


class SixStepParams(NamedTuple):
    """Terminal R in ohm, L in H, peak torque per ampere in N m/A, pole pairs, offset (rad, el.), trapezoid: 1."""

    resistance: float
    inductance: float
    constant: float
    pole_pairs: float
    offset: float
    trapezoid: float


@loop
def hall_sector(params: SixStepParams, angle: float) -> int:
    """Sector 0 to 5 that the Hall sensors tell at a shaft angle (rad)."""
    turned = params.pole_pairs * angle + params.offset
    return math.floor(turned / (math.pi / 3.0)) % 6


@loop
def six_step_torque(params: SixStepParams, angle: float) -> float:
    """Torque per ampere (N m/A), and back-emf of the two conducting phases (V s/rad), at a shaft angle (rad)."""
    middle = (hall_sector(params, angle) + 0.5) * (math.pi / 3.0)
    x = params.pole_pairs * angle - middle
    if params.trapezoid == 0.0:
        return params.constant * math.cos(x)
    away = abs(x - 2.0 * math.pi * round(x / (2.0 * math.pi)))
    return params.constant * min(max(1.5 - away * 3.0 / math.pi, -1.0), 1.0)


@loop
def six_step_step(
    params: SixStepParams, current: float, voltage: float, angle: float, speed: float, dt: float
) -> float:
    """Current (A) of the conducting pair `dt` s later; exact while voltage (V) and back-emf are held."""
    settled = (voltage - six_step_torque(params, angle) * speed) / params.resistance
    return settled + math.exp(-params.resistance * dt / params.inductance) * (current - settled)


@dataclass(frozen=True, slots=True)
class SixStep:
    """Block commutation, and how far its sensors are off.

    Raises
    ------
    ModelError
    """

    sensor_offset: float = parameter(
        0.0, meaning="of the Hall sensors, electrical, positive: too early", unit="rad", least=-math.pi, most=math.pi
    )
    back_emf: str = parameter("sine", meaning="shape of the motor's", choices=("sine", "trapezoid"))

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def mean_over_peak(self) -> float:
        """Mean torque over the greatest one at the same current; of sines `3/pi cos(offset)`."""
        if self.back_emf == "sine":
            return 3.0 / math.pi * math.cos(self.sensor_offset)
        low, high = self.sensor_offset - 0.5 * SECTOR, self.sensor_offset + 0.5 * SECTOR
        return (_area(high) - _area(low)) / SECTOR

    @property
    def ripple_over_mean(self) -> float:
        """Peak to peak over mean; infinite where no torque is left."""
        low, high = self.sensor_offset - 0.5 * SECTOR, self.sensor_offset + 0.5 * SECTOR
        shape = math.cos if self.back_emf == "sine" else _trapezoid
        ends = (shape(low), shape(high))
        peak = 1.0 if low <= 0.0 <= high else max(ends)
        mean = abs(self.mean_over_peak)
        return (peak - min(ends)) / mean if mean > 1e-9 else math.inf

    def params(self, motor: Pmsm) -> SixStepParams:
        """Params of `six_step_step`: two phases of the motor in series."""
        inductance = motor.inductance_d + motor.inductance_q  # twice the mean of the two axes
        trapezoid = self.back_emf == "trapezoid"
        constant = (2.0 if trapezoid else math.sqrt(3.0)) * motor.pole_pairs * motor.flux
        return SixStepParams(
            2.0 * motor.resistance,
            inductance,
            constant,
            float(motor.pole_pairs),
            self.sensor_offset,
            1.0 if trapezoid else 0.0,
        )

    def torque(self, motor: Pmsm, speed: float) -> float:
        """Mean torque, N m, at full voltage and a speed (rad/s): the steady characteristic, within the current."""
        require("SixStep.torque", "speed", speed)
        params = self.params(motor)
        k = params.constant * self.mean_over_peak
        current = (motor.max_voltage - k * speed) / params.resistance
        return k * max(min(current, motor.max_current), -motor.max_current)


def _trapezoid(x: float) -> float:
    """Back-emf of two phases over its peak, x from the middle of its flat top (rad): 1 to 30 degrees, -1 from 150."""
    return min(max(1.5 - abs(x) / SECTOR, -1.0), 1.0)


def _area(x: float) -> float:
    """Integral of `_trapezoid` from 0 to x."""
    away = min(abs(x), 0.5 * SECTOR)
    fall = min(max(abs(x) - 0.5 * SECTOR, 0.0), 2.0 * SECTOR)
    below = max(abs(x) - 2.5 * SECTOR, 0.0)
    return math.copysign(away + fall - 0.5 * fall * fall / SECTOR - below, x)
