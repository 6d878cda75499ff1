"""Compiled steps of encoders: counter, its extension, speeds; nothing is checked or allocated.

Angles and speeds are the motor shaft's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.trace.code.loops import loop

__all__ = [
    "COUNTER_SIZE",
    "EncoderParams",
    "TrackingParams",
    "TrackingState",
    "count_angle",
    "difference_speed",
    "encoder_counter",
    "extend_counter",
    "tracking_step",
]

COUNTER_SIZE = 1 << 16
HALF_COUNTER = COUNTER_SIZE >> 1


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
    return math.floor(angle * params.counts_per_rad) & (COUNTER_SIZE - 1)


@loop
def extend_counter(total: int, counter: int) -> int:
    """64-bit count after a read: the last one plus the signed 16-bit difference (spec 03.3).

    The low 16 bits of `total` are the last read, so `total` is the whole state. Right for any motion of less
    than 2^15 counts between two reads.
    """
    return total + ((counter - total + HALF_COUNTER) & (COUNTER_SIZE - 1)) - HALF_COUNTER


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
