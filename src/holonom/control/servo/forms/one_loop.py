"""One loop: a PID regulator of the angle, or a PI of the speed, gives the voltage."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.servo import law_kernels
from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.cascade import LOOP_DELAY, resolvable_crossover
from holonom.control.servo.kernels import SpeedParams
from holonom.control.servo.law_design import Servo, ServoGains, servo_law, slowed
from holonom.registry import Method

__all__ = ["ONE_LOOP", "OneLoop"]

MARGIN = math.radians(60.0)  # of the speed's part, before that of the angle takes its few degrees


@dataclass(frozen=True, slots=True, kw_only=True)
class OneLoop(Servo):
    """PID of the angle, or with a reference of the speed PI, on the motor's voltage.

    Notes
    -----
    A motor without a current loop is `1/k_e / ((1 + s T_m)(1 + s T_e))`, `T_m = J R / (k_t k_e)`. The zero lies on T_m,
    so that the loop is an integrator with the small lags; 60 deg are left. The voltage stays within what drives the
    greatest current through the resistance at the speed there is, so that the current overshoots its limit by as little
    as the observer is late.
    """

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains; the margin `angle` is that of the whole regulator, opened at the voltage."""
        times, law = times or SampleTimes(), servo_law(form=law_kernels.ONE_LOOP)
        friction = axis.resistance * axis.viscous / axis.torque_constant
        lag = axis.inertia * axis.resistance / axis.torque_constant / (axis.back_emf_constant + friction)
        by_sampling = (0.5 * math.pi - MARGIN) / (axis.inductance / axis.resistance + LOOP_DELAY * times.speed)
        by_counts = resolvable_crossover(axis)
        gain = min(by_sampling, by_counts) * axis.inertia / axis.torque_constant
        speed = SpeedParams(
            gain, gain * times.speed / lag, axis.max_current, axis.max_voltage, axis.back_emf_constant,
            1.0 / axis.resistance,
        )  # fmt: skip
        return slowed(axis, law, speed, times, MARGIN, corner=False)


ONE_LOOP = Method(
    "position PID, or speed PI, on the voltage; no current loop",
    lambda servo: servo,
    "Leonhard, Control of Electrical Drives; specification 04.3, 04.5",
    OneLoop,
)
