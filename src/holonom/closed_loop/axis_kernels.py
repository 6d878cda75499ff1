"""The closed loop of one axis, compiled: the servo's step and the plant's in turn, at the rate of the current loop."""

from __future__ import annotations

from holonom.arrays import Array
from holonom.devices.encoders.kernels import encoder_counter
from holonom.machine.axis.kernels import AxisServoParams, AxisServoState, axis_servo_step
from holonom.sim.axis.kernels import AxisPlantParams, AxisState, axis_step
from holonom.trace.code.loops import loop

__all__ = ["ROWS", "run_axis"]

ROWS = 10
"""Rows of the log."""


@loop(error_model="numpy")
def run_axis(
    plant: AxisPlantParams,
    servo: AxisServoParams,
    state: AxisState,
    seen: AxisServoState,
    reference: Array,
    loads: Array,
    log: Array,
) -> tuple[AxisState, AxisServoState]:
    """Run along reference samples (3, ticks) of the position loop; fill log (10, ticks), a column at its start.

    Rows of the log: load angle, motor angle, load speed, motor speed, current, voltage, current reference, speed
    reference, mean of the squared current, estimated speed; at the motor shaft.
    """
    k = 0
    for tick in range(reference.shape[1]):
        heat = 0.0
        log[0, tick], log[1, tick] = state.load_angle, state.angle
        log[2, tick], log[3, tick] = state.load_speed, state.speed
        log[4, tick], log[5, tick] = state.current, seen.voltage
        log[6, tick], log[7, tick], log[9, tick] = seen.current_reference, seen.speed_reference, seen.rate
        r, v, a, load = reference[0, tick], reference[1, tick], reference[2, tick], loads[tick]
        for _ in range(servo.position_samples):
            counter = encoder_counter(servo.encoder, state.angle)
            seen = axis_servo_step(servo, seen, k, counter, state.current, r, v, a)
            state = axis_step(plant, state, seen.voltage, load)
            heat += state.current * state.current
            k += 1
        log[8, tick] = heat / servo.position_samples
    return state, seen
