"""The position is measured at the load, the speed at the motor."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.law_design import Servo, ServoGains, law_gains, servo_law
from holonom.errors import ModelError
from holonom.registry import Method

__all__ = ["LOAD_SIDE", "LoadSide"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadSide(Servo):
    """Three loops; position by an encoder on the load, so that neither twist nor backlash is an error at rest."""

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains; the position's margin counts the shaft in."""
        if not axis.load_counts > 0.0:
            raise ModelError("LoadSide: the axis has no encoder on its load; state one (load_encoder of the Axis)")
        return law_gains(axis, servo_law(on_load=True), times=times)


LOAD_SIDE = Method(
    "three loops, position by an encoder on the load",
    lambda servo: servo,
    "Ellis, Control System Design Guide, ch. 17; specification 04.3",
    LoadSide,
)
