"""Position over current: a PID regulator of the angle gives the current."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.servo import law_kernels
from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.law_design import Servo, ServoGains, law_gains, servo_law
from holonom.registry import OWN, Method

__all__ = ["TWO_LOOPS", "TwoLoops"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoLoops(Servo):
    """PID of the angle over the current loop.

    Notes
    -----
    `i = K (k e + w_ref - w) + K_i integral(k e + w_ref - w)`: P, I and D on the angle in one regulator at the
    sample time of the speed loop; as `k e + w_ref - w` is what is integrated, a step does not overshoot.
    Far from its goal `k e` is the root that the axis can brake on.
    """

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains; the margin `angle` is that of the whole regulator, opened at the current."""
        return law_gains(axis, servo_law(form=law_kernels.TWO_LOOPS), times=times)


TWO_LOOPS = Method("position PID over current PI", lambda servo: servo, f"{OWN}; specification 04.3", TwoLoops)
