"""An arm with its drives, compiled once for every robot: its dynamics come in as the address of a kernel.

Motor and arm every 0.1 ms. Each axis is a record of parameters and a record of state (`records.py`); devices are their
own scalar steps, which take the nested records as their params.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.drive_signals import JointSignals
from holonom.devices.encoders.kernels import encoder_counter
from holonom.devices.motors.kernels import armature_step
from holonom.devices.transmission.kernels import geared_step
from holonom.trace.call.pointer import call_kernel
from holonom.trace.code.loops import loop

__all__ = ["arm_step", "compare", "sense"]

Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def arm_step(
    plant: int, dt: float, axes: Records, states: Records, signals: JointSignals, source: Array, target: Array
) -> float:
    """One step of `dt` (s) under the voltages of `signals`; its currents are written. Return the contact force, N.

    `plant` is the address of the arm's kernel; `source` (3 n + 7,) ends with payload and ground, `target` is (n + 1,).
    """
    n = states.shape[0]
    for i in range(n):
        _drive(axes[i], states[i], signals.voltages[i])
        source[i], source[n + i], source[2 * n + i] = states[i].position, states[i].speed, states[i].torque
    call_kernel(plant, source, target)
    for i in range(n):
        _move(states[i], target[i], dt)
        signals.currents[i] = states[i].current
    return float(target[n])


@loop(error_model="numpy", forceinline=True)
def sense(axes: Records, states: Records, signals: JointSignals) -> None:
    """Write the counters of the encoders."""
    for i in range(states.shape[0]):
        axis = axes[i]
        signals.counters[i] = encoder_counter(axis.encoder, axis.gear.ratio * states[i].position)


@loop(error_model="numpy", forceinline=True)
def compare(states: Records, reference: Array) -> None:
    """Following errors: the true positions against a reference (n,)."""
    for i in range(states.shape[0]):
        state = states[i]
        error = reference[i] - state.position
        state.peak_error = max(state.peak_error, abs(error))
        state.square_error += error * error


@loop(error_model="numpy", forceinline=True)
def _drive(axis: Any, state: Any, voltage: float) -> None:
    """Armature, motor friction and gear of one step."""
    speed = axis.gear.ratio * state.speed
    state.current = armature_step(axis.armature, state.current, voltage, speed)
    motor = axis.torque_constant * state.current
    state.voltage = voltage
    state.torque, state.held = geared_step(axis.friction, axis.gear, state.held, motor, speed)
    state.peak_voltage = max(state.peak_voltage, abs(voltage))
    state.peak_current = max(state.peak_current, abs(state.current))
    state.peak_torque = max(state.peak_torque, abs(state.torque))


@loop(error_model="numpy", forceinline=True)
def _move(state: Any, acceleration: float, dt: float) -> None:
    """Semi-implicit Euler: speed first, then position with the new speed."""
    state.speed += dt * acceleration
    state.position += dt * state.speed
    state.peak_speed = max(state.peak_speed, abs(state.speed))
