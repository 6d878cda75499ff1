"""The multi-rate loop of all axes, compiled once for every robot: a robot comes in as the addresses of its kernels.

Current loop, motor and arm every 0.1 ms, speed loop every 0.5 ms, position loop every 1 ms. Each axis is a record of
parameters and a record of state (`records.py`); devices and regulators are their own scalar steps, which take the
nested records as their params.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.control.kernels import (
    acceleration_step,
    axis_violation,
    current_step,
    position_step,
    speed_step,
    torque_to_current,
)
from holonom.devices.kernels import (
    TrackingState,
    armature_step,
    count_angle,
    encoder_counter,
    extend_counter,
    friction_torque,
    gear_torque,
    tracking_step,
)
from holonom.trace.loops import loop
from holonom.trace.pointer import call_kernel

__all__ = ["CASCADE", "COMPUTED_TORQUE", "POSITION_TICK", "SPEED_TICK", "STOP", "advance"]

CASCADE, COMPUTED_TORQUE, STOP = 0, 1, 2
"""Who commands the current loops: the cascade, the model-based law, or the speed loops holding zero speed."""

SPEED_TICK, POSITION_TICK = 5, 10
"""Sample times of the speed and position loops, in steps of the current loop."""

Floats = NDArray[np.float64]
Records = NDArray[np.void]


@loop(error_model="numpy")
def advance(
    mode: int,
    plant: int,
    model: int,
    dt: float,
    axes: Records,
    states: Records,
    reference: Floats,
    surroundings: Floats,
    work: Floats,
) -> tuple[int, int, int, float]:
    """Advance all axes over reference samples of 1 kHz.

    Parameters
    ----------
    mode
        CASCADE, COMPUTED_TORQUE or STOP.
    plant, model
        Addresses of the arm's plant kernel and of the controller's inverse dynamics.
    dt
        Step of the current loop, s.
    axes, states
        (n,) records `AXIS` and `STATE`; the states are advanced in place.
    reference
        (3, ticks, n): positions, speeds, accelerations.
    surroundings
        (7,): payload mass and centre of mass, ground height, stiffness, damping.
    work
        Scratch, (8 n + 8,).

    Returns
    -------
    Violation code (0: none), the axis and 1 kHz tick at which it was found, largest contact force (N).
    """
    n = states.shape[0]
    source, target, law = work[: 3 * n + 7], work[3 * n + 7 : 4 * n + 8], work[4 * n + 8 :]
    source[3 * n :] = surroundings
    touch = 0.0
    for step in range(reference.shape[1] * POSITION_TICK):
        tick = step // POSITION_TICK
        if step % SPEED_TICK == 0:
            for i in range(n):
                _read_encoder(axes[i], states[i])
        if step % POSITION_TICK == 0 and mode != STOP:
            for i in range(n):
                code = _watch(axes[i], states[i], reference[0, tick, i])
                if code != 0:
                    return code, i, tick, touch
            if mode == CASCADE:
                for i in range(n):
                    _position_loop(axes[i], states[i], reference[0, tick, i], reference[1, tick, i])
            else:
                _model_law(model, axes, states, reference[:, tick], law)
        if step % SPEED_TICK == 0 and mode != COMPUTED_TORQUE:
            for i in range(n):
                _speed_loop(axes[i], states[i], mode)
        for i in range(n):
            _drive(axes[i], states[i])
            source[i] = states[i].position
            source[n + i] = states[i].speed
            source[2 * n + i] = states[i].torque
        call_kernel(plant, source, target)
        touch = max(touch, float(target[n]))
        for i in range(n):
            _move(states[i], target[i], dt)
    return 0, 0, 0, touch


@loop(error_model="numpy")
def _read_encoder(axis: Any, state: Any) -> None:
    """Counter, its 64-bit extension and the observer; the motor's own torque is the acceleration it knows of."""
    counter = encoder_counter(axis.encoder, axis.gear.ratio * state.position)
    state.count = extend_counter(state.count, counter)
    known = axis.torque_constant * state.current / axis.inertia
    before = TrackingState(state.angle, state.rate, state.load)
    after = tracking_step(axis.tracking, before, count_angle(axis.encoder, state.count), known)
    state.angle, state.rate, state.load = after.angle, after.speed, after.load


@loop(error_model="numpy")
def _watch(axis: Any, state: Any, reference: float) -> int:
    """Following error statistics (true position), and the limits as the controller sees them."""
    error = reference - state.position
    state.peak_error = max(state.peak_error, abs(error))
    state.square_error += error * error
    ratio = axis.gear.ratio
    return axis_violation(axis.limits, reference, state.angle / ratio, state.rate / ratio, state.current)


@loop(error_model="numpy")
def _position_loop(axis: Any, state: Any, reference: float, speed: float) -> None:
    ratio = axis.gear.ratio
    state.speed_reference = position_step(axis.position, ratio * reference, ratio * speed, state.angle)


@loop(error_model="numpy")
def _speed_loop(axis: Any, state: Any, mode: int) -> None:
    wanted = 0.0 if mode == STOP else state.speed_reference
    state.current_reference, state.speed_integral = speed_step(
        axis.speed, state.speed_integral, wanted, state.rate, 0.0
    )


@loop(error_model="numpy")
def _model_law(model: int, axes: Records, states: Records, reference: Floats, law: Floats) -> None:
    """tau = B(q) u + h(q, qd_ref): friction is fed forward along the reference, so that it does not chatter at rest."""
    n = states.shape[0]
    source, target = law[: 3 * n], law[3 * n :]
    for i in range(n):
        axis, state = axes[i], states[i]
        position, speed = state.angle / axis.gear.ratio, state.rate / axis.gear.ratio
        u, state.law_integral = acceleration_step(
            axis.law,
            state.law_integral,
            reference[0, i] - position,
            reference[1, i] - speed,
            reference[2, i],
            state.saturated,
        )
        source[i], source[n + i], source[2 * n + i] = position, reference[1, i], u
    call_kernel(model, source, target)
    for i in range(n):
        axis, state = axes[i], states[i]
        per_ampere = axis.gear.ratio * axis.torque_constant
        state.current_reference, state.saturated = torque_to_current(target[i], per_ampere, axis.speed.max_current)


@loop(error_model="numpy")
def _drive(axis: Any, state: Any) -> None:
    """Current loop, armature, motor friction and gear of one step."""
    speed = axis.gear.ratio * state.speed
    voltage, state.current_integral = current_step(
        axis.current, state.current_integral, state.current_reference, state.current, state.rate
    )
    state.current = armature_step(axis.armature, state.current, voltage, speed)
    motor = axis.torque_constant * state.current - friction_torque(axis.friction, speed)
    state.voltage = voltage
    state.torque = gear_torque(axis.gear, motor, speed)
    state.peak_voltage = max(state.peak_voltage, abs(voltage))
    state.peak_current = max(state.peak_current, abs(state.current))
    state.peak_torque = max(state.peak_torque, abs(state.torque))


@loop(error_model="numpy")
def _move(state: Any, acceleration: float, dt: float) -> None:
    """Semi-implicit Euler: speed first, then position with the new speed."""
    state.speed += dt * acceleration
    state.position += dt * state.speed
    state.peak_speed = max(state.peak_speed, abs(state.speed))
