"""Backlash compensation: at a reversal the motor crosses the gap quickly."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.cascade import design_current, design_speed
from holonom.control.servo.law_design import Servo, ServoGains, law_gains, servo_law, slowed
from holonom.errors import ModelError
from holonom.registry import Method, parameter

__all__ = ["BACKLASH", "Backlash"]

PACE = 0.2  # of the crossover with the rotor alone, with which it comes to the other flank; faster, it rattles
ALONE = math.radians(45.0)  # of phase that the speed loop keeps in the gap, where it has the rotor alone


@dataclass(frozen=True, slots=True, kw_only=True)
class Backlash(Servo):
    """Three loops; the motor is led half a gap ahead of the load, on the side of the motion.

    Raises
    ------
    OutOfLimits
        A number outside its range.

    Notes
    -----
    When the reference's speed changes its sign the motor's reference moves by the gap, first with the crossing speed,
    then slower towards the other flank, and its speed is fed forward. References need their speed (row 1). In the gap
    the loop has the rotor alone, whose inertia is less: the speed loop is slowed down until it keeps 45 deg there, too.
    """

    gap: float | None = parameter(None, meaning="at the motor; that of the axis unless given", unit="rad")
    crossing: float = parameter(0.2, meaning="speed in the gap, part of the greatest", unit="", above=0.0, most=1.0)

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains of the cascade, and the gap."""
        times, gap = times or SampleTimes(), axis.gap if self.gap is None else self.gap
        if not gap > 0.0:
            raise ModelError("Backlash: the axis has no gap and none is given")
        rotor = dataclasses.replace(
            axis, inertia=axis.inertia - axis.load_inertia, load_inertia=0.0, stiffness=math.inf
        )
        usual, _, _ = design_speed(axis, times, design_current(axis, times.current, True))
        alone = slowed(rotor, servo_law(), usual, times, ALONE)
        gain = min(PACE * alone.margins["speed"].crossover, 0.5 / times.position)
        law = servo_law(gap=gap, crossing=self.crossing * alone.position.max_speed, crossing_gain=gain)
        return law_gains(axis, law, times=times, speed=alone.speed)


BACKLASH = Method(
    "three loops, the gap of the gear is crossed quickly at a reversal",
    lambda servo: servo,
    "Nordin, Gutman, Controlling mechanical systems with backlash, Automatica 38(10), 2002; specification 03.2",
    Backlash,
)
