"""A wheel of the plant about its vertical axis, compiled: steering motor or trailing castor, and its contact's way."""

from __future__ import annotations

import math
from typing import Any

from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop

__all__ = ["cosine_sine", "swing", "swung", "turn_on"]

FLAGS = {"contract"}


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def swung(wheel: Any, own: Any, across: Any, stiffness: Any, h: float, w: float) -> tuple[Any, Any]:
    """Force across and its slope as the base feels them, with the turn about the vertical axis eliminated.

    `J dpsi = h (d F + T)` where F falls by k d dpsi and the torque T of motor or bearing by its own slope.
    """
    motor, lever = wheel.steering, wheel.lever
    turning = own.swing - w
    rate = min(max((own.asked - own.motor) / motor.lag, -motor.max_rate), motor.max_rate) * own.free
    gap = own.motor - own.turned
    wound = math.copysign(max(abs(gap) - motor.half_backlash, 0.0), gap)
    taut = select(abs(gap) >= motor.half_backlash, wheel.servo, 0.0)
    pull = taut * (motor.stiffness * wound + motor.damping * (rate - turning))
    held = min(max(pull, -motor.max_torque), motor.max_torque)
    slope = select(abs(pull) < motor.max_torque, taut * (motor.damping + h * motor.stiffness), 0.0)
    bearing = (1.0 - wheel.servo) * wheel.pivot_drag
    own.moment, own.moment_slope = held - bearing * turning, slope + bearing
    own.motor_rate = rate
    own.motor += h * rate
    give = h / (motor.inertia + h * (own.moment_slope + stiffness * lever * lever))
    lost = stiffness * lever * give
    return across - lost * (lever * across + own.moment), stiffness - lost * stiffness * lever


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def swing(wheel: Any, own: Any, across: Any, h: float) -> Any:
    """Turn a wheel's rate about its vertical axis on, by the final force across; return the torque (N m) on it."""
    inertia = wheel.steering.inertia
    change = h * (wheel.lever * across + own.moment) / (inertia + h * own.moment_slope)
    own.moment -= own.moment_slope * change
    own.moment_slope = change  # from here on the change of rate, which the step's mean rate is half of
    own.swing += wheel.turns * change
    return wheel.turns * own.moment


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def turn_on(wheel: Any, own: Any, h: float, w: float) -> None:
    """Turn a wheel on about its vertical axis, with the directions of its forces."""
    angle = h * wheel.turns * (own.swing - w)
    own.turned += angle
    c, s = cosine_sine(angle)
    x, y = c * own.along_x - s * own.along_y, s * own.along_x + c * own.along_y
    length = 1.5 - 0.5 * (x * x + y * y)
    x, y = length * x, length * y
    own.along_x, own.along_y, own.along_arm = x, y, wheel.x * y - wheel.y * x
    own.across_x, own.across_y = select(wheel.turns > 0.0, -y, own.across_x), select(wheel.turns > 0.0, x, own.across_y)
    own.across_arm = wheel.x * own.across_y - wheel.y * own.across_x


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def cosine_sine(angle: Any) -> tuple[Any, Any]:
    """Cosine and sine of the turn of one step, by their series; exact to rounding below 0.1 rad."""
    z = angle * angle
    cosine = 1.0 - z / 2.0 * (1.0 - z / 12.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0)))
    return cosine, angle * (1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0))))
