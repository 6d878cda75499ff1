"""Compiled copies of what is true of a base into its log, once each millisecond."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.devices.drive_signals import WheelSignals
from holonom.sim.base.step_kernels import BasePlantParams, advance
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, packed

__all__ = ["drive_open", "log_body", "log_wheels"]

Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def log_body(known: Any, body: Any, row: Any) -> None:
    """Log the true state of base_link, which the body `known` carries beside its centre of mass, and the energies."""
    x, y = known.com_x, known.com_y
    s, c = sincos(body.theta)
    row.x, row.y, row.theta = body.x - c * x + s * y, body.y - s * x - c * y, body.theta
    row.vx, row.vy, row.w = body.vx + body.w * y, body.vy - body.w * x, body.w
    row.ax, row.ay = body.ax, body.ay
    row.supplied, row.heat, row.airgap = body.supplied, body.heat, body.airgap
    row.drag, row.ground = body.drag, body.ground
    row.pitch = body.pitch


@loop(error_model="numpy", forceinline=True)
def log_wheels(states: Records, rows: Records) -> None:
    """Log all wheels, four in each row: motor, forces on the floor, slip."""
    for i in range(len(states)):
        own, row = packed(states[i]), packed(rows[i])
        row.speed, row.angle = own.speed, own.angle
        row.current, row.voltage = own.current, own.voltage
        row.force, row.cross_force, row.load, row.slip = own.along, own.across, own.load, own.slip
        row.friction_limit = own.load * own.material.peak
        row.turned, row.asked = own.turned, own.asked


@loop(error_model="numpy")
def drive_open(
    params: BasePlantParams,
    state: Records,
    states: Records,
    signals: WheelSignals,
    noise: Array,
    voltages: Array,
    body_log: Records,
    wheel_log: Records,
) -> None:
    """Drive the motors with voltages (N, m), one row each millisecond, without any controller."""
    for k in range(len(voltages)):
        log_body(params.body[0], state[0], body_log[k])
        for i in range(voltages.shape[1]):
            signals.voltages[i] = voltages[k, i]
            states[i // WIDTH].voltage[i % WIDTH] = voltages[k, i]
        log_wheels(states, wheel_log[k])
        advance(params, state, states, signals, noise)
