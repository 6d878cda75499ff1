"""Limits of nested loops: what a loop asks for is never clipped further inside (specification 04.3)."""

from __future__ import annotations

from holonom.control.servo.axis import DesignWarning, ServoAxis
from holonom.control.servo.kernels import CurrentParams, PositionParams, SpeedParams

__all__ = ["drivable_speed", "unmatched"]

CLOSE = 1.0 + 1e-9


def drivable_speed(axis: ServoAxis) -> float:
    """Speed (rad/s) at which the whole supply goes into back-emf and viscous friction: `U / (k_e + R B / k_t)`."""
    return axis.max_voltage / (axis.back_emf_constant + axis.resistance * axis.viscous / axis.torque_constant)


def unmatched(
    axis: ServoAxis, current: CurrentParams, speed: SpeedParams, position: PositionParams
) -> list[DesignWarning]:
    """Limits of a servo that do not match, and those of its axis that nothing inside can give.

    Position: its greatest speed is one that the supply drives. Speed: its greatest current is the power stage's, and
    the regulator itself asks for no more than the supply drives at the speed there is. Current: its voltage is the
    supply's.
    """
    pairs = (
        ("speed_limit", "the position loop asks for", position.max_speed, drivable_speed(axis), "rad/s"),
        ("speed_limit", "the axis is to turn with", axis.max_speed, drivable_speed(axis), "rad/s"),
        ("current_limit", "the speed loop asks for", speed.max_current, axis.max_current, "A"),
        ("voltage_limit", "the speed loop counts on", speed.max_voltage, current.max_voltage, "V"),
        ("voltage_limit", "the current loop asks for", current.max_voltage, axis.max_voltage, "V"),
    )
    return [
        DesignWarning(
            name, f"{who} {value:.5g} {unit}, what is inside gives {most:.5g} {unit}: it is clipped there", value, most
        )
        for name, who, value, most, unit in pairs
        if value > CLOSE * most
    ]
