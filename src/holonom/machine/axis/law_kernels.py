"""The servos of one axis beside the default cascade, compiled: what `axis_servo_step` is to that."""

from __future__ import annotations

from holonom.control.servo.kernels import current_step, position_step
from holonom.control.servo.law_kernels import ONE_LOOP, THREE_LOOPS, LawState, gap_shift, law_speed_step
from holonom.devices.encoders.kernels import TrackingState, count_angle, tracking_step
from holonom.machine.axis.kernels import CURRENT_LOOP, POSITION_LOOP, SPEED_LOOP, AxisServoParams, AxisServoState
from holonom.trace.code.loops import loop

__all__ = ["law_servo_step"]


@loop(error_model="numpy", forceinline=True)
def law_servo_step(
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
    """One step of the current loop under a law; arguments as those of `axis_servo_step`."""
    p, s, law = params, state, params.law
    counts, angle, rate, load = s.counts, s.angle, s.rate, s.load
    speed_reference, next_speed, memory = s.speed_reference, s.next_speed, s.law
    current_reference, next_current, speed_integral = s.current_reference, s.next_current, s.speed_integral
    sampled = k % p.speed_samples == 0
    if sampled:
        counts = s.offset + count
        known = p.acceleration_per_ampere * current
        seen = tracking_step(p.tracking, TrackingState(angle, rate, load), count_angle(p.encoder, counts), known)
        angle, rate, load = seen.angle, seen.speed, seen.load
        three = law.form == THREE_LOOPS
        if p.outer == POSITION_LOOP and (not three or k % p.position_samples == 0):
            dt = p.tracking.dt * (p.position_samples // p.speed_samples if three else 1)
            shift, crossing = gap_shift(law, memory.shift, speed, dt)
            at = count_angle(p.load_encoder, load_count) if law.on_load else angle
            asked = position_step(p.position, reference + shift, speed + crossing, at)
            speed_reference, next_speed = (next_speed if three else asked), asked
            memory = LawState(memory.lead, memory.notch, shift)
        elif p.outer == SPEED_LOOP:
            speed_reference += p.following * (reference - speed_reference)
    if p.outer != CURRENT_LOOP and (sampled or law.tachometer):
        ahead = acceleration / p.acceleration_per_ampere + p.viscous_current * speed
        ahead -= law.compensation * load / p.acceleration_per_ampere
        if law.form == ONE_LOOP:
            ahead += p.speed.conductance * p.speed.back_emf * speed
        if speed > 0.0:
            ahead += p.friction_current
        elif speed < 0.0:
            ahead -= p.friction_current
        shown = tachometer if law.tachometer else rate
        current_reference = next_current
        next_current, speed_integral, memory = law_speed_step(
            law, p.speed, memory, speed_integral, speed_reference, shown, ahead
        )
    if p.outer == CURRENT_LOOP:
        current_reference = reference
    if law.form == ONE_LOOP:
        voltage, next_voltage = current_reference / p.speed.conductance, next_current / p.speed.conductance
        current_integral = 0.0
    else:
        voltage = s.next_voltage
        next_voltage, current_integral = current_step(p.current, s.current_integral, current_reference, current, rate)
    return AxisServoState(
        s.offset, counts, angle, rate, load, current_integral, speed_integral, speed_reference, current_reference,
        voltage, next_speed, next_current, next_voltage, memory,
    )  # fmt: skip
