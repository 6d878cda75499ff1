"""The servo of one axis, compiled: from counter and shunt to the motor's voltage; the plant it never sees.

A step is one of the current loop; the loops around it run every so many. What a loop computes from a sample acts one
of its samples later, as in a digital drive: with the hold that is the delay of 1.5 samples that the design counts on.
"""

from __future__ import annotations

from typing import NamedTuple

from holonom.control.servo.kernels import (
    CurrentParams,
    PositionParams,
    SpeedParams,
    current_step,
    position_step,
    speed_step,
)
from holonom.devices.encoders.kernels import (
    EncoderParams,
    TrackingParams,
    TrackingState,
    count_angle,
    extend_counter,
    tracking_step,
)
from holonom.trace.code.loops import loop

__all__ = ["CURRENT_LOOP", "POSITION_LOOP", "SPEED_LOOP", "AxisServoParams", "AxisServoState", "axis_servo_step"]

POSITION_LOOP, SPEED_LOOP, CURRENT_LOOP = 0, 1, 2
"""Which reference a caller gives: angle (rad), speed (rad/s), or current (A), all at the motor."""


class AxisServoParams(NamedTuple):
    """What the servo knows of its axis, and its gains; at the motor shaft."""

    encoder: EncoderParams
    tracking: TrackingParams
    current: CurrentParams
    speed: SpeedParams
    position: PositionParams
    acceleration_per_ampere: float  # k_t / J, rad/s2 per A
    viscous_current: float  # B / k_t, A s/rad
    friction_current: float  # Coulomb friction over k_t, A
    speed_samples: int  # of the current loop to one of the speed loop
    position_samples: int
    outer: int  # the outermost loop


class AxisServoState(NamedTuple):
    """What it remembers; `next_` is computed and waits for its sample."""

    counts: int
    angle: float
    rate: float
    load: float
    current_integral: float
    speed_integral: float
    speed_reference: float
    current_reference: float
    voltage: float
    next_speed: float
    next_current: float
    next_voltage: float


@loop(error_model="numpy", forceinline=True)
def axis_servo_step(
    params: AxisServoParams,
    state: AxisServoState,
    k: int,
    counter: int,
    current: float,
    reference: float,
    speed: float,
    acceleration: float,
) -> AxisServoState:
    """One step of the current loop: `voltage` of the state that comes back acts until the next one.

    Parameters
    ----------
    params, state
        Of this axis.
    k
        Steps before.
    counter, current
        What is measured: the encoder's 16 bits; A.
    reference, speed, acceleration
        Of the outermost loop, and what is fed forward: rad/s and rad/s2 at the motor.
    """
    p, s = params, state
    counts, angle, rate, load = s.counts, s.angle, s.rate, s.load
    speed_reference, next_speed = s.speed_reference, s.next_speed
    current_reference, next_current, speed_integral = s.current_reference, s.next_current, s.speed_integral
    if k % p.speed_samples == 0:
        counts = extend_counter(counts, counter)
        known = p.acceleration_per_ampere * current
        seen = tracking_step(p.tracking, TrackingState(angle, rate, load), count_angle(p.encoder, counts), known)
        angle, rate, load = seen.angle, seen.speed, seen.load
        if p.outer == POSITION_LOOP and k % p.position_samples == 0:
            speed_reference = next_speed
            next_speed = position_step(p.position, reference, speed, angle)
        elif p.outer == SPEED_LOOP:
            speed_reference = reference
        if p.outer != CURRENT_LOOP:
            ahead = acceleration / p.acceleration_per_ampere + p.viscous_current * speed
            if speed > 0.0:
                ahead += p.friction_current
            elif speed < 0.0:
                ahead -= p.friction_current
            current_reference = next_current
            next_current, speed_integral = speed_step(p.speed, speed_integral, speed_reference, rate, ahead)
    if p.outer == CURRENT_LOOP:
        current_reference = reference
    voltage = s.next_voltage
    next_voltage, current_integral = current_step(p.current, s.current_integral, current_reference, current, rate)
    return AxisServoState(
        counts, angle, rate, load, current_integral, speed_integral, speed_reference, current_reference, voltage,
        next_speed, next_current, next_voltage,
    )  # fmt: skip
