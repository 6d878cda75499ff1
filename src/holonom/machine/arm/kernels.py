"""The servos of all axes, compiled once for every arm: the inverse dynamics come in as the address of a kernel.

Each axis is a record of parameters and a record of state (`records.py`); regulators are their own scalar steps, which
take the nested records as their params. One step is one of the current loop; the loops around it run every so many.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.servo.kernels import (
    acceleration_step,
    axis_violation,
    current_step,
    position_step,
    speed_step,
    torque_to_current,
)
from holonom.devices.drive_signals import JointSignals
from holonom.devices.encoders.kernels import TrackingState, count_angle, extend_counter, tracking_step
from holonom.machine.arm.records import ServoTiming
from holonom.trace.call.pointer import call_kernel
from holonom.trace.code.loops import loop

__all__ = ["CASCADE", "COMPUTED_TORQUE", "CURRENT", "STOP", "servo_step"]

CASCADE, COMPUTED_TORQUE, STOP, CURRENT = 0, 1, 2, 3
"""Who commands the current loops: the cascade, the model-based law, the speed loops holding zero speed, or a caller."""

Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def servo_step(
    mode: int,
    timing: ServoTiming,
    step: int,
    model: int,
    axes: Records,
    states: Records,
    reference: Array,
    signals: JointSignals,
    law: Array,
) -> tuple[int, int]:
    """One step of the current loop: from counters and currents in `signals` to the voltages in it.

    Parameters
    ----------
    mode
        CASCADE, COMPUTED_TORQUE, STOP or CURRENT: with that the current references in `states` are the caller's.
    timing, step
        Sample times of the loops around it; how many steps went before.
    model
        Address of the arm's inverse dynamics.
    axes, states
        (n,) records `SERVO` and `SERVO_STATE`; the states are advanced in place.
    reference
        (3, n): position, speed, acceleration of this millisecond.
    law
        Scratch, (4 n,).

    Returns
    -------
    Violation code (0: none) and the axis; then no voltage has changed.
    """
    n = states.shape[0]
    if step % timing.speed == 0:
        for i in range(n):
            _read_encoder(axes[i], states[i], signals.counters[i], signals.currents[i])
    if step % timing.position == 0 and mode != STOP:
        for i in range(n):
            code = _watch(axes[i], states[i], reference[0, i], signals.currents[i])
            if code != 0:
                return code, i
        if mode == CASCADE:
            for i in range(n):
                _position_loop(axes[i], states[i], reference[0, i], reference[1, i])
    if mode == COMPUTED_TORQUE:
        if step % timing.model == 0:
            _model_law(model, axes, states, reference, law)
        if step % timing.model == timing.delay:
            for i in range(n):
                states[i].current_reference = states[i].coming_reference
    elif mode != CURRENT and step % timing.speed == 0:
        for i in range(n):
            _speed_loop(axes[i], states[i], mode)
    for i in range(n):
        axis, state = axes[i], states[i]
        signals.voltages[i], state.current_integral = current_step(
            axis.current, state.current_integral, state.current_reference, signals.currents[i], state.rate
        )
    return 0, 0


@loop(error_model="numpy", forceinline=True)
def _read_encoder(axis: Any, state: Any, counter: int, current: float) -> None:
    """64-bit extension of the counter and observer; the motor's own torque is the acceleration it knows of."""
    state.count = extend_counter(state.count, counter)
    known = axis.torque_constant * current / axis.inertia
    before = TrackingState(state.angle, state.rate, state.load)
    after = tracking_step(axis.tracking, before, count_angle(axis.encoder, state.count), known)
    state.angle, state.rate, state.load = after.angle, after.speed, after.load


@loop(error_model="numpy", forceinline=True)
def _watch(axis: Any, state: Any, reference: float, current: float) -> int:
    """The limits as the controller sees them."""
    return axis_violation(axis.limits, reference, state.angle / axis.ratio, state.rate / axis.ratio, current)


@loop(error_model="numpy", forceinline=True)
def _position_loop(axis: Any, state: Any, reference: float, speed: float) -> None:
    state.speed_reference = position_step(axis.position, axis.ratio * reference, axis.ratio * speed, state.angle)


@loop(error_model="numpy", forceinline=True)
def _speed_loop(axis: Any, state: Any, mode: int) -> None:
    wanted = 0.0 if mode == STOP else state.speed_reference
    state.current_reference, state.speed_integral = speed_step(
        axis.speed, state.speed_integral, wanted, state.rate, 0.0
    )


@loop(error_model="numpy", forceinline=True)
def _model_law(model: int, axes: Records, states: Records, reference: Array, law: Array) -> None:
    """tau = B(q) u + h(q, qd_ref): friction is fed forward along the reference, so that it does not chatter at rest."""
    n = states.shape[0]
    source, target = law[: 3 * n], law[3 * n :]
    for i in range(n):
        axis, state = axes[i], states[i]
        position, speed = state.angle / axis.ratio, state.rate / axis.ratio
        u, state.law_integral = acceleration_step(
            axis.law,
            state.law_integral,
            reference[0, i] - position,
            reference[1, i] - speed,
            reference[2, i],
            state.saturated != 0,
        )
        source[i], source[n + i], source[2 * n + i] = position, reference[1, i], u
    call_kernel(model, source, target)
    for i in range(n):
        axis, state = axes[i], states[i]
        per_ampere = axis.ratio * axis.torque_constant
        current, clipped = torque_to_current(target[i], per_ampere, axis.speed.max_current)
        state.coming_reference, state.saturated = current, 1 if clipped else 0
