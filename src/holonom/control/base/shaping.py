"""Settings of a twist that is asked for: how fast it may change, how long it holds."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from holonom.control.base.shaping_kernels import AxisShape, ShapingParams
from holonom.errors import OutOfLimits

__all__ = ["ShapingSettings"]

DEAD_BANDS = ("dead_band", "turn_dead_band")


@dataclass(frozen=True, slots=True)
class ShapingSettings:
    """Limits of a base that follows velocities, per axis; law in `control.base.shaping_kernels.shaping_step`.

    Attributes
    ----------
    speed, acceleration, jerk
        Along x of base_link: m/s, m/s^2, m/s^3; along y too, unless that has its own.
    side_speed, side_acceleration, side_jerk
        Along y; None: as along x.
    turn_rate, turn_acceleration, turn_jerk
        The same of turning: rad/s, rad/s^2, rad/s^3.
    timeout
        s after which a twist that is not asked for again is no longer followed: the base stops within its limits.
    dead_band, turn_dead_band
        m/s and rad/s: a twist below both is rest.

    Raises
    ------
    OutOfLimits
        A number that is not positive (a dead band may be 0), or not finite (the time-out may be infinite).
    """

    speed: float = 2.0
    acceleration: float = 2.0
    jerk: float = 20.0
    turn_rate: float = 6.0
    turn_acceleration: float = 20.0
    turn_jerk: float = 200.0
    timeout: float = 0.2
    side_speed: float | None = None
    side_acceleration: float | None = None
    side_jerk: float | None = None
    dead_band: float = 0.0
    turn_dead_band: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is None:
                continue
            if field.name in DEAD_BANDS:
                if not 0.0 <= value < math.inf:
                    raise OutOfLimits(f"ShapingSettings: {field.name} is {value!r}; it must be finite and at least 0")
            elif not (value > 0.0 and (math.isfinite(value) or field.name == "timeout")):
                raise OutOfLimits(f"ShapingSettings: {field.name} is {value!r}; it must be finite and greater than 0")

    def params(self, dt: float) -> ShapingParams:
        """Params of the step at a sample time, s."""
        linear = AxisShape(self.speed, self.acceleration, self.jerk)
        turning = AxisShape(self.turn_rate, self.turn_acceleration, self.turn_jerk)
        sideways = AxisShape(
            linear.speed if self.side_speed is None else self.side_speed,
            linear.acceleration if self.side_acceleration is None else self.side_acceleration,
            linear.jerk if self.side_jerk is None else self.side_jerk,
        )
        return ShapingParams(dt, self.timeout, self.dead_band, self.turn_dead_band, linear, sideways, turning)
