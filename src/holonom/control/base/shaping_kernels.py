"""Compiled steps of a base that follows velocities: the nearest twist that it can drive, speeds within limits."""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.trace.code.loops import loop

__all__ = ["AxisShape", "ShapingParams", "awake", "drivable_twist", "shaping_step"]


class AxisShape(NamedTuple):
    """Limits of one component of a twist: speed, acceleration, jerk (m/s, or rad/s, and their derivatives)."""

    speed: float
    acceleration: float
    jerk: float


class ShapingParams(NamedTuple):
    """Following a twist: s after which it is too old, m/s and rad/s below which it is rest; limits of each part."""

    dt: float
    timeout: float
    dead_band: float
    turn_dead_band: float
    forwards: AxisShape
    sideways: AxisShape
    turning: AxisShape


@loop(error_model="numpy")
def awake(params: ShapingParams, vx: float, vy: float, w: float) -> float:
    """1 for a twist that is followed, 0 within the dead band."""
    rests = vx * vx + vy * vy < params.dead_band * params.dead_band and abs(w) < params.turn_dead_band
    return 0.0 if rests else 1.0


@loop(error_model="numpy")
def drivable_twist(drivable: Array, rows: Array, twist: Planar, max_rim: float) -> Planar:
    """Nearest twist that drags no wheel (`drivable` (3, 3) projects), no faster than the wheels reach (m/s)."""
    x = drivable[0, 0] * twist.x + drivable[0, 1] * twist.y + drivable[0, 2] * twist.turn
    y = drivable[1, 0] * twist.x + drivable[1, 1] * twist.y + drivable[1, 2] * twist.turn
    turn = drivable[2, 0] * twist.x + drivable[2, 1] * twist.y + drivable[2, 2] * twist.turn
    fastest = max_rim
    for i in range(rows.shape[0]):
        fastest = max(fastest, abs(rows[i, 0] * x + rows[i, 1] * y + rows[i, 2] * turn))
    part = max_rim / fastest
    return Planar(part * x, part * y, part * turn)


@loop(error_model="numpy")
def shaping_step(dt: float, shape: AxisShape, speed: float, acceleration: float, goal: float) -> tuple[float, float]:
    """Speed and acceleration one sample later on the way to a speed: within its limits, without overshoot.

    It aims at the acceleration from which n samples, each less by what jerk allows, end at the goal at rest:
    `n a - c n (n - 1) / 2 = e / dt` with `c = j dt`, n as small as can be; time optimal.
    """
    error = min(max(goal, -shape.speed), shape.speed) - speed
    change, steps = dt * shape.jerk, abs(error) / dt
    n = max(math.ceil(0.5 * (math.sqrt(1.0 + 8.0 * steps / change) - 1.0) - 1e-9), 1)
    aim = math.copysign(min(steps / n + 0.5 * change * (n - 1), shape.acceleration), error)
    acceleration = min(max(aim, acceleration - change), acceleration + change)
    return speed + dt * acceleration, acceleration
