"""Compiled copies of a base's state into its log, once each millisecond."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.trace.loops import loop
from holonom.trace.simd import packed

__all__ = ["log_body", "log_reference", "log_wheels"]

Floats = NDArray[np.float64]
Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def log_reference(now: Floats, rate: float, row: Any) -> None:
    """Log the reference (9,) and the rate at which it advances."""
    row.ref_x, row.ref_y, row.ref_theta = now[0], now[1], now[2]
    row.ref_vx, row.ref_vy, row.ref_w = now[3], now[4], now[5]
    row.rate = rate


@loop(error_model="numpy", forceinline=True)
def log_body(base: Any, gyro: float, imu_x: float, imu_y: float, row: Any) -> None:
    """Log true and estimated state of the body, what gyro and accelerometers measure, and the energies."""
    row.x, row.y, row.theta = base.x, base.y, base.theta
    row.vx, row.vy, row.w = base.vx, base.vy, base.w
    row.seen_x, row.seen_y, row.seen_theta = base.seen_x, base.seen_y, base.seen_theta
    row.seen_vx, row.seen_vy, row.seen_w = base.seen_vx, base.seen_vy, base.seen_w
    row.gyro, row.imu_x, row.imu_y = gyro, imu_x, imu_y
    row.supplied, row.heat, row.airgap, row.drag, row.ground = (
        base.supplied,
        base.heat,
        base.airgap,
        base.drag,
        base.ground,
    )


@loop(error_model="numpy", forceinline=True)
def log_wheels(wheels: Records, states: Records, rows: Records) -> None:
    """Log all wheels, four in each row: motor, forces on the floor, slip."""
    for i in range(len(wheels)):
        wheel, own, row = packed(wheels[i]), packed(states[i]), packed(rows[i])
        row.speed = own.speed
        row.measured_speed = own.seen_speed / wheel.gear.ratio
        row.current, row.measured_current, row.voltage = own.current, own.measured_current, own.voltage
        row.force, row.cross_force, row.load, row.slip = own.along, own.across, own.load, own.slip
        row.friction_limit = own.load * own.material.peak
