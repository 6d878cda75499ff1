"""Torque control with disturbance compensation: what the observer sees of a load goes into the current at once."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.cascade import design_current, design_speed
from holonom.control.servo.law_design import Servo, ServoGains, law_gains, servo_law
from holonom.registry import Method, parameter

__all__ = ["DISTURBANCE", "Disturbance"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbance(Servo):
    """Three loops, speed P; the observer's unmodelled acceleration, over k_t / J, is taken from the current reference.

    Raises
    ------
    OutOfLimits
        A number outside its range.

    Notes
    -----
    `i_ref = K (w_ref - w) - part J d / k_t`, d of the tracking loop that gives the speed from the counts and the
    measured current. It takes the place of the integral: with `part` 1 a constant load leaves no error, with less a
    part of it. If motor and inertia are as known, d is the load alone and the margins are those of the loop without it.
    """

    part: float = parameter(1.0, meaning="of the disturbance that is compensated", unit="", above=0.0, most=1.0)

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains, with the margins of the nominal axis."""
        times = times or SampleTimes()
        speed, _, _ = design_speed(axis, times, design_current(axis, times.current, True))
        law = servo_law(compensation=self.part)
        return law_gains(axis, law, times=times, speed=speed._replace(integral_gain=0.0))


DISTURBANCE = Method(
    "three loops, speed P with the load that the observer sees",
    lambda servo: servo,
    "Ohnishi, Shibata, Murakami, Motion control for advanced mechatronics, IEEE/ASME T-Mech 1(1), 1996; spec 04.5",
    Disturbance,
)
