"""The servo of one axis, compiled: from counter and shunt to the motor's voltage; the plant it never sees.

A step is one of the current loop; the loops around it run every so many. What a loop computes from a sample acts one
of its samples later, as in a digital drive: with the hold that is the delay of 1.5 samples that the design counts on.
"""

from __future__ import annotations

from typing import Any, NamedTuple

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
    tracking_step,
)
from holonom.trace.code.loops import loop

__all__ = [
    "CURRENT_LOOP",
    "POSITION_LOOP",
    "SPEED_LOOP",
    "AxisServoParams",
    "AxisServoState",
    "axis_servo_step",
    "current_between",
    "current_only",
    "homed",
    "powered",
    "standing",
]

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
    speed_lead: float  # samples of the position loop, by which what is fed forward comes ahead of the loops' delays
    acceleration_lead: float
    following: float  # part by which the reference of a speed loop is followed each of its samples, 1: at once
    load_encoder: EncoderParams  # of the load, at the motor
    law: Any  # () of the default cascade, or `LawParams`
    law_start: Any  # () or `LawState`


class AxisServoState(NamedTuple):
    """What it remembers.

    `offset` is the homed count where the counter is at zero; `next_` is computed and waits for its sample; `law` is ()
    of the default cascade, or a `LawState`.
    """

    offset: int
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
    law: Any


@loop(error_model="numpy", forceinline=True)
def axis_servo_step(
    params: AxisServoParams,
    state: AxisServoState,
    k: int,
    count: int,
    current: float,
    reference: float,
    speed: float,
    acceleration: float,
    load_count: int,
    tachometer: float,
) -> AxisServoState:
    """One step of the current loop: `voltage` of the state that comes back acts until the next one.

    Parameters
    ----------
    params, state
        Of this axis.
    k
        Steps before.
    count, current
        What is measured: the counter since power-on; A.
    reference, speed, acceleration
        Of the outermost loop, and what is fed forward: rad/s and rad/s2 at the motor.
    load_count, tachometer
        Of the load's encoder; rad/s: for other servos, see `law_servo_step`.
    """
    p, s = params, state
    counts, angle, rate, load = s.counts, s.angle, s.rate, s.load
    speed_reference, next_speed = s.speed_reference, s.next_speed
    current_reference, next_current, speed_integral = s.current_reference, s.next_current, s.speed_integral
    if k % p.speed_samples == 0:
        counts = s.offset + count
        known = p.acceleration_per_ampere * current
        seen = tracking_step(p.tracking, TrackingState(angle, rate, load), count_angle(p.encoder, counts), known)
        angle, rate, load = seen.angle, seen.speed, seen.load
        if p.outer == POSITION_LOOP and k % p.position_samples == 0:
            speed_reference = next_speed
            next_speed = position_step(p.position, reference, speed, angle)
        elif p.outer == SPEED_LOOP:
            speed_reference += p.following * (reference - speed_reference)
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
        s.offset, counts, angle, rate, load, current_integral, speed_integral, speed_reference, current_reference,
        voltage, next_speed, next_current, next_voltage, s.law,
    )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def current_between(params: AxisServoParams, state: AxisServoState, current: float) -> AxisServoState:
    """`axis_servo_step` at a step that is no sample of the outer loops."""
    s = state
    next_voltage, integral = current_step(params.current, s.current_integral, s.current_reference, current, s.rate)
    return AxisServoState(
        s.offset, s.counts, s.angle, s.rate, s.load, integral, s.speed_integral, s.speed_reference,
        s.current_reference, s.next_voltage, s.next_speed, s.next_current, next_voltage, s.law,
    )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def current_only(params: AxisServoParams, state: AxisServoState, asked: float, current: float) -> AxisServoState:
    """One step of the current loop alone, for an asked current (A), without any word of the encoder."""
    s = state
    next_voltage, integral = current_step(params.current, s.current_integral, asked, current, 0.0)
    return AxisServoState(
        s.offset, s.counts, s.angle, 0.0, 0.0, integral, 0.0, 0.0, asked, s.next_voltage, 0.0, asked, next_voltage,
        params.law_start,
    )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def standing(params: AxisServoParams, state: AxisServoState, count: int) -> AxisServoState:
    """The servo of an axis without power: it knows where the shaft is, and nothing else."""
    counts = state.offset + count
    angle = count_angle(params.encoder, counts)
    return AxisServoState(
        state.offset, counts, angle, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, params.law_start
    )


@loop(error_model="numpy", forceinline=True)
def powered(state: AxisServoState, hold: float) -> AxisServoState:
    """The servo of an axis that is switched on where it stands: its speed loop begins with a current (A), bumpless."""
    s = state
    return AxisServoState(s.offset, s.counts, s.angle, 0.0, 0.0, 0.0, hold, 0.0, hold, 0.0, 0.0, hold, 0.0, s.law)


@loop(error_model="numpy", forceinline=True)
def homed(params: AxisServoParams, state: AxisServoState, offset: int) -> AxisServoState:
    """The servo that knows its zero now: position = count + offset; nothing moves for it."""
    s, moved = state, offset - state.offset
    return AxisServoState(
        offset, s.counts + moved, s.angle + moved * params.encoder.resolution, s.rate, s.load, s.current_integral,
        s.speed_integral, 0.0, s.current_reference, s.voltage, 0.0, s.next_current, s.next_voltage, s.law,
    )  # fmt: skip
