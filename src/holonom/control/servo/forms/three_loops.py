"""Position over speed over current, each with its own sample: the default cascade."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.cascade import CascadeGains, design_cascade
from holonom.control.servo.law_design import Servo
from holonom.registry import Method

__all__ = ["THREE_LOOPS", "ThreeLoops"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ThreeLoops(Servo):
    """`design_cascade`."""

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> CascadeGains:
        """Gains of the cascade."""
        return design_cascade(axis, times=times)


THREE_LOOPS = Method(
    "position P over speed PI over current PI",
    lambda servo: servo,
    "Leonhard, Control of Electrical Drives; specification 04.3",
    ThreeLoops,
)
