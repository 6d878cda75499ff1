"""Settings of the loop that keeps a base on its path, and of its velocity estimate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import inf

from holonom.control.base.kernels import EstimateParams, KeepingParams
from holonom.registry import check_fields, parameter

__all__ = ["EstimateSettings", "KeepingSettings"]


@dataclass(frozen=True, slots=True)
class KeepingSettings:
    """Feed-forward and PI on the pose error, acceleration limited; law in `control.base.kernels.keeping_step`.

    Raises
    ------
    OutOfLimits
        A number that is not positive.
    """

    bandwidth: float = parameter(
        6.0, meaning="of the position and heading loops: their proportional gain", unit="rad/s", above=0.0
    )
    integral_time: float = parameter(1.0, meaning="of the integral, infinite for none", unit="s", above=0.0, most=inf)
    velocity_bandwidth: float = parameter(
        15.0, meaning="acceleration asked for per velocity error", unit="rad/s", above=0.0
    )
    max_correction: float = parameter(
        0.6, meaning="largest speed that an error may add", unit="m/s", above=0.0, most=inf
    )
    max_turn_correction: float = parameter(
        4.0, meaning="largest turning rate that an error may add", unit="rad/s", above=0.0, most=inf
    )
    max_acceleration: float = parameter(6.0, meaning="of the commanded twist", unit="m/s2", above=0.0, most=inf)
    max_turn_acceleration: float = parameter(80.0, meaning="of the commanded twist", unit="rad/s2", above=0.0, most=inf)

    def __post_init__(self) -> None:
        check_fields(self)

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
    """Velocity from gyro, accelerometers and wheels; law in `control.base.kernels.estimate_step`.

    The largest pull keeps all wheels spinning at once from carrying it away.

    Raises
    ------
    OutOfLimits
        A number that is not positive.
    """

    bandwidth: float = parameter(
        50.0, meaning="with which the wheels correct the carried velocity", unit="rad/s", above=0.0
    )
    max_pull: float = parameter(0.2, meaning="largest such correction", unit="m/s2", above=0.0, most=inf)
    bias_time: float = parameter(
        20.0, meaning="in which wheels correct the gyro's zero, infinite for never", unit="s", above=0.0, most=inf
    )

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, dt: float) -> EstimateParams:
        """Params of `estimate_step` at a sample time, s."""
        return EstimateParams(dt, 1.0 - math.exp(-self.bandwidth * dt), self.max_pull, dt / self.bias_time)
