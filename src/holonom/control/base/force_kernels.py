"""Compiled: force that a base's acceleration takes, shared among its wheels, and what of it they can make.

Bases come in as in `control.base.kernels`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.control.base.kernels import Planar, ground_speed
from holonom.trace.code.loops import loop

__all__ = ["Body", "allocation", "feasible_rate", "force_part", "wrench_of"]


class Body(NamedTuple):
    """A rigid body: mass, kg, inertia about its centre of mass, kg m^2, and where that is in base_link, m."""

    mass: float
    inertia: float
    com_x: float
    com_y: float


@loop(error_model="numpy")
def allocation(rows: Array, weights: Array, out: Array) -> None:
    """Fill `out` (m, 3): rim forces (N) per force and torque on the base, `f = W D (D^T W D)^-1 F`.

    The forces of least weighted square that make F; a wheel of weight 0 takes no part. With fewer than three
    wheels left not every F can be made: those that can are, within 1 in 10^6.
    """
    a = np.zeros((3, 3))
    for i in range(rows.shape[0]):
        for j in range(3):
            for k in range(3):
                a[j, k] += weights[i] * rows[i, j] * rows[i, k]
    for j in range(3):
        a[j, j] = a[j, j] * (1.0 + 1e-6) + 1e-12
    inverse = np.linalg.inv(a)
    for i in range(rows.shape[0]):
        for j in range(3):
            out[i, j] = weights[i] * (
                rows[i, 0] * inverse[0, j] + rows[i, 1] * inverse[1, j] + rows[i, 2] * inverse[2, j]
            )


@loop(error_model="numpy")
def force_part(share: Array, wanted: Planar, limits: Array) -> float:
    """Part (0 to 1) of a wanted force (N, N, N m) that no wheel needs more than its limit (m,), N, for."""
    worst = 1.0
    for i in range(share.shape[0]):
        worst = max(worst, abs(ground_speed(share, i, wanted)) / limits[i])
    return 1.0 / worst


@loop(error_model="numpy")
def wrench_of(body: Body, acceleration: Planar, turn_rate: float) -> Planar:
    """Force and torque about base_link (N, N, N m) that its acceleration (m/s^2, rad/s^2) takes, along its axes.

    Newton and Euler, about the centre of mass c: `F = M (a + wd x c - w^2 c)`, `torque = I wd + c x F`.
    """
    wd, square = acceleration.turn, turn_rate * turn_rate
    fx = body.mass * (acceleration.x - wd * body.com_y - square * body.com_x)
    fy = body.mass * (acceleration.y + wd * body.com_x - square * body.com_y)
    return Planar(fx, fy, body.inertia * wd + body.com_x * fy - body.com_y * fx)


@loop(error_model="numpy")
def feasible_rate(share: Array, reference: Array, first: int, body: Body, limits: Array) -> float:
    """Part (0 to 1) of its speed at which the rest of a reference (N, 9) can be driven with forces within limits (m,).

    Driven at a rate r, a path needs r^2 of its accelerations.
    """
    part = 1.0
    for k in range(first, reference.shape[0]):
        a = reference[k]
        part = min(part, force_part(share, wrench_of(body, Planar(a[6], a[7], a[8]), a[5]), limits))
    return math.sqrt(part)
