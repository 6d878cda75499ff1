"""Settings of the loop that keeps a base on its path, and of its velocity estimate."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from holonom.control.base_kernels import EstimateParams, KeepingParams
from holonom.errors import OutOfLimits

__all__ = ["EstimateSettings", "KeepingSettings"]


@dataclass(frozen=True, slots=True)
class KeepingSettings:
    """Feed-forward and PI on the pose error, acceleration limited; law in `control.base_kernels.keeping_step`.

    Attributes
    ----------
    bandwidth
        Of the position and heading loops, rad/s: their proportional gain.
    integral_time
        Of the integral, s; infinite for none.
    velocity_bandwidth
        rad/s: acceleration asked for per velocity error.
    max_correction, max_turn_correction
        Largest speed that an error may add, m/s and rad/s.
    max_acceleration, max_turn_acceleration
        m/s^2 and rad/s^2, of the commanded twist.

    Raises
    ------
    OutOfLimits
        A number that is not positive.
    """

    bandwidth: float = 6.0
    integral_time: float = 1.0
    velocity_bandwidth: float = 15.0
    max_correction: float = 0.6
    max_turn_correction: float = 4.0
    max_acceleration: float = 6.0
    max_turn_acceleration: float = 80.0

    def __post_init__(self) -> None:
        _all_positive(self)

    def params(self, dt: float) -> KeepingParams:
        """Params of `keeping_step` at a sample time, s."""
        integral = self.bandwidth / self.integral_time
        return KeepingParams(
            dt=dt,
            position_gain=self.bandwidth,
            position_integral=integral,
            heading_gain=self.bandwidth,
            heading_integral=integral,
            velocity_gain=self.velocity_bandwidth,
            turn_rate_gain=self.velocity_bandwidth,
            max_correction=self.max_correction,
            max_turn_correction=self.max_turn_correction,
            max_acceleration=self.max_acceleration,
            max_turn_acceleration=self.max_turn_acceleration,
        )


@dataclass(frozen=True, slots=True)
class EstimateSettings:
    """Velocity from gyro, accelerometers and wheels; law in `control.base_kernels.estimate_step`.

    Attributes
    ----------
    bandwidth
        rad/s, with which the wheels correct the carried velocity.
    max_pull
        m/s^2, at most, so that all wheels spinning at once do not carry it away.
    bias_time
        s, in which the wheels' turning rate corrects the gyro's zero; infinite for never.

    Raises
    ------
    OutOfLimits
        A number that is not positive.
    """

    bandwidth: float = 50.0
    max_pull: float = 0.2
    bias_time: float = 20.0

    def __post_init__(self) -> None:
        _all_positive(self)

    def params(self, dt: float) -> EstimateParams:
        """Params of `estimate_step` at a sample time, s."""
        return EstimateParams(dt, 1.0 - math.exp(-self.bandwidth * dt), self.max_pull, dt / self.bias_time)


def _all_positive(settings: KeepingSettings | EstimateSettings) -> None:
    for field in fields(settings):
        value = getattr(settings, field.name)
        if not value > 0.0:
            raise OutOfLimits(f"{type(settings).__name__}: {field.name} is {value!r}; it must be greater than 0")
