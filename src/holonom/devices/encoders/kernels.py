"""Compiled steps of encoders: counter, its extension, speeds; nothing is checked or allocated.

Angles and speeds are the motor shaft's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.devices.encoders.counters.counter import unwrap_count, wrap_count
from holonom.trace.code.loops import loop

__all__ = [
    "SERVO_BITS",
    "EncoderParams",
    "TrackingParams",
    "TrackingState",
    "count_angle",
    "difference_speed",
    "encoder_counter",
    "extend_counter",
    "tracking_step",
]

SERVO_BITS = 16
"""Of the counters of servo axes."""


class EncoderParams(NamedTuple):
    """Counts per radian of the motor shaft after decoding, and its inverse in rad."""

    counts_per_rad: float
    resolution: float


class TrackingParams(NamedTuple):
    """A tracking loop at interval `dt`: corrections of angle (1), speed (1/s), load (1/s^2) per error."""

    dt: float
    angle_gain: float
    speed_gain: float
    load_gain: float


class TrackingState(NamedTuple):
    """Estimated angle (rad), speed (rad/s) and unmodelled acceleration (rad/s^2) of the motor shaft."""

    angle: float
    speed: float
    load: float


@loop
def encoder_counter(params: EncoderParams, angle: float) -> int:
    """Content (0 ... 65535) of the 16-bit up/down counter at a motor angle (rad)."""
    return wrap_count(SERVO_BITS, math.floor(angle * params.counts_per_rad))


@loop
def extend_counter(total: int, counter: int) -> int:
    """64-bit count after a read of a 16-bit counter: `unwrap_count` (spec 03.3)."""
    return unwrap_count(SERVO_BITS, total, counter)


@loop
def count_angle(params: EncoderParams, total: int) -> float:
    """Motor angle (rad) at the middle of the count: off by half a count at most."""
    return (total + 0.5) * params.resolution


@loop
def difference_speed(params: EncoderParams, counts: int, interval: float) -> float:
    """M method: motor speed (rad/s) from the counts in an interval (s), `dN q / T_s`; half of it late."""
    return counts * params.resolution / interval


@loop
def tracking_step(params: TrackingParams, state: TrackingState, angle: float, acceleration: float) -> TrackingState:
    """One read of the encoder: predict with the known acceleration (`k_t i / J`, or 0), correct by the error.

    With the right inertia the speed has no delay. The load state takes up whatever the acceleration leaves
    out (gravity, friction, a wrong inertia), so that nothing constant biases the speed.
    """
    dt = params.dt
    total = acceleration + state.load
    predicted = state.angle + dt * (state.speed + 0.5 * dt * total)
    error = angle - predicted
    return TrackingState(
        predicted + params.angle_gain * error,
        state.speed + dt * total + params.speed_gain * error,
        state.load + params.load_gain * error,
    )
