"""An inner loop by tachometer: it closes at the current loop's rate and knows no counts."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.law_design import Servo, ServoGains, law_gains, servo_law
from holonom.registry import Method

__all__ = ["TACHOMETER", "Tachometer"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Tachometer(Servo):
    """Three loops; the speed is a tachometer's, regulated each sample of the current loop.

    Notes
    -----
    Without the encoder's counts and the speed loop's slower sample its crossover is several times as high, and with it
    what is left of a dead zone, friction's too: `dead zone / (1 + A T)` with the loop's gain.
    """

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains; the speed loop's delay is 1.5 samples of the current loop."""
        return law_gains(axis, servo_law(tachometer=True), times=times)


TACHOMETER = Method(
    "three loops, speed by tachometer at the current loop's rate",
    lambda servo: servo,
    "specification 03, 04.3: inner loop against dead zone",
    Tachometer,
)
