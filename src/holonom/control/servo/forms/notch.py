"""A notch between speed and current against the resonance of an elastic shaft."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.cascade import design_current, design_speed
from holonom.control.servo.law_design import Servo, ServoGains, servo_law, slowed
from holonom.control.servo.law_kernels import BiquadParams
from holonom.errors import ModelError
from holonom.registry import Method, parameter

__all__ = ["NOTCH", "Notch", "notch_params"]

MARGIN = math.radians(45.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Notch(Servo):
    """Three loops; `(s^2 + 2 d_z w s + w^2)/(s^2 + 2 d_p w s + w^2)` behind the speed's regulator.

    Raises
    ------
    OutOfLimits
        A number outside its range.

    Notes
    -----
    w is the axis's resonance `sqrt(c (1/J_M + 1/J_L))` unless given. The loop is slowed down until 45 deg are left at
    each crossing.
    """

    frequency: float | None = parameter(None, meaning="of the notch; the axis's resonance unless given", unit="rad/s")
    depth: float = parameter(0.05, meaning="d_z / d_p: what is left at the frequency", unit="", above=0.0, most=1.0)
    width: float = parameter(0.6, meaning="d_p", unit="", above=0.0, most=2.0)

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains of an elastic axis, or of any where the frequency is given."""
        times = times or SampleTimes()
        if self.frequency is None and math.isinf(axis.stiffness):
            raise ModelError("Notch: the axis is rigid and no frequency is given: state its stiffness, or a frequency")
        frequency = axis.resonance if self.frequency is None else self.frequency
        filtering = notch_params(frequency, self.depth, self.width, times.speed)
        speed, _, _ = design_speed(axis, times, design_current(axis, times.current, True))
        return slowed(axis, servo_law(notch=filtering), speed, times, MARGIN)


def notch_params(frequency: float, depth: float, width: float, dt: float) -> BiquadParams:
    """Params of a notch at a frequency (rad/s), by Tustin, exact there.

    Raises
    ------
    ModelError
        A frequency that samples of `dt` (s) do not show.
    """
    if not 0.0 < frequency < math.pi / dt:
        raise ModelError(
            f"Notch: the frequency is {frequency:g} rad/s; samples of {dt:g} s show less than {math.pi / dt:g} rad/s: "
            "sample the speed loop faster"
        )
    t = math.tan(0.5 * frequency * dt)
    zero, pole = 2.0 * depth * width * t, 2.0 * width * t
    d = 1.0 + pole + t * t
    return BiquadParams(
        (1.0 + zero + t * t) / d, 2.0 * (t * t - 1.0) / d, (1.0 - zero + t * t) / d, 2.0 * (t * t - 1.0) / d,
        (1.0 - pole + t * t) / d,
    )  # fmt: skip


NOTCH = Method(
    "three loops, a notch at the resonance of an elastic shaft",
    lambda servo: servo,
    "Ellis, Control System Design Guide, ch. 16; specification 04.5",
    Notch,
)
