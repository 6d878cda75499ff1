"""Incremental encoder on a motor shaft, its 16-bit counter, and the ways to a speed (spec 03.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.encoders.counters.counter import Counter
from holonom.devices.encoders.kernels import SERVO_BITS, EncoderParams, TrackingParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Encoder", "tracking_params"]


@dataclass(frozen=True, slots=True)
class Encoder:
    """An incremental encoder on the motor shaft.

    Raises
    ------
    ModelError
        Fewer than one count per turn.
    """

    counts_per_rev: int = parameter(
        meaning="counts per turn of the motor after decoding, four per line with 4x decoding", least=1, example=1000
    )

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def resolution(self) -> float:
        """One count, rad of the motor shaft."""
        return 2.0 * math.pi / self.counts_per_rev

    def longest_read_interval(self, max_speed: float, *, counter_bits: int = SERVO_BITS) -> float:
        """Time (s) within which a counter has to be read at a motor speed (rad/s): `Counter.longest_read_interval`."""
        return Counter(counter_bits).longest_read_interval(self.counts_per_rev, max_speed)

    def speed_resolution(self, interval: float) -> float:
        """Step (rad/s) of the M method, `q / T_s`, at an interval in s."""
        require("Encoder.speed_resolution", "interval", interval, above=0.0)
        return self.resolution / interval

    def params(self) -> EncoderParams:
        """Params of the counter kernels."""
        return EncoderParams(1.0 / self.resolution, self.resolution)


def tracking_params(bandwidth: float, dt: float) -> TrackingParams:
    """Params of `tracking_step` for an observer with three poles at `-bandwidth` (rad/s), read each `dt` (s).

    The poles lie at `r = exp(-bandwidth dt)` (fading-memory filter; Zarchan, Fundamentals of Kalman
    Filtering). One count of position error moves the speed by at most about `0.8 bandwidth` counts per
    second.

    Raises
    ------
    ModelError
        A bandwidth or an interval that is not positive.
    """
    require("tracking_params", "bandwidth", bandwidth, above=0.0)
    require("tracking_params", "dt", dt, above=0.0)
    r = math.exp(-bandwidth * dt)
    return TrackingParams(
        dt=dt,
        angle_gain=1.0 - r**3,
        speed_gain=1.5 * (1.0 - r) ** 2 * (1.0 + r) / dt,
        load_gain=(1.0 - r) ** 3 / dt**2,
    )
