"""Compiled steps of what a base does not know of its pose: numbers and arrays in, arrays changed; nothing is checked.

Two kinds of errors add up. Noise is new in each sample; its covariance (3, 3) is carried along the path. What is
constant but unknown, the gyro's zero, a wheel's creep, is a standard normal variable each; how much of every one is in
the pose is carried along: columns of a matrix (4, 9), rows x, y, theta, zero of the gyro. The pose's covariance is the
sum of both (Siegwart & Nourbakhsh (5.9), with the constants as states).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["CONSTANTS", "UncertaintyParams", "pose_covariance", "start_uncertainty", "uncertainty_step"]


CONSTANTS = 9
"""Unknown constants: the gyro's zero; two of the accelerometers'; creep by drag and by push; wheels' size; turning by
the square of acceleration, and by its two parts."""
ZERO, AHEAD, LEFT, DRAG, PUSH, SIZE, SQUARE, LEAN_X, LEAN_Y = range(CONSTANTS)
SLOW = 0.02  # m/s, below which drag fades


class UncertaintyParams(NamedTuple):
    """Standard deviations; see `control.base.uncertainty.UncertaintySettings`."""

    dt: float
    start: float  # m, and rad per metre of lever: of the first pose
    start_turn: float
    turn_noise: float  # variance of heading per sample, rad^2
    way_noise: float  # variance of either place per sample, m^2
    gyro_bias: float  # rad/s
    bias_gain: float  # part of it that wheels correct per sample
    drift: float  # m/s
    drag_creep: float  # m/s
    scale: float
    force_creep: float  # s, the mean of both directions, and half of what it is more ahead than to the left
    force_creep_difference: float
    turn_square: float  # rad/s per (m/s^2)^2
    turn_lean_x: float  # rad/s per m/s^2
    turn_lean_y: float


@loop(error_model="numpy")
def start_uncertainty(params: UncertaintyParams, constants: Array, noise: Array) -> None:
    """Fill `constants` (4, 9) and `noise` (3, 3) with those of a base that stands at a pose it knows."""
    constants[:] = 0.0
    constants[3, ZERO] = params.gyro_bias
    noise[:] = 0.0
    noise[0, 0] = noise[1, 1] = params.start * params.start
    noise[2, 2] = params.start_turn * params.start_turn


@loop(error_model="numpy")
def uncertainty_step(
    params: UncertaintyParams, constants: Array, noise: Array, heading: float, twist: Planar, acceleration: Planar
) -> None:
    """Carry both a sample further, at a heading (rad) and with a twist and acceleration (base_link)."""
    dt = params.dt
    s, c = sincos(heading + 0.5 * dt * twist.turn)
    dx, dy = dt * (c * twist.x - s * twist.y), dt * (s * twist.x + c * twist.y)
    square = acceleration.x * acceleration.x + acceleration.y * acceleration.y
    for j in range(CONSTANTS):
        ahead, left, wheels = 0.0, 0.0, 0.0
        if j == AHEAD:
            ahead = params.drift
        elif j == LEFT:
            left = params.drift
        elif j == DRAG:
            speed = math.sqrt(twist.x * twist.x + twist.y * twist.y + SLOW * SLOW)
            ahead, left = params.drag_creep * twist.x / speed, params.drag_creep * twist.y / speed
        elif j == PUSH:
            difference = params.force_creep_difference
            ahead, left = difference * acceleration.x, -difference * acceleration.y
        elif j == SIZE:
            ahead, left = params.scale * twist.x, params.scale * twist.y
        elif j == SQUARE:
            wheels = params.turn_square * square
        elif j == LEAN_X:
            wheels = params.turn_lean_x * acceleration.x
        elif j == LEAN_Y:
            wheels = params.turn_lean_y * acceleration.y
        turned = constants[2, j] + 0.5 * dt * constants[3, j]
        constants[0, j] += dt * (c * ahead - s * left) - dy * turned
        constants[1, j] += dt * (s * ahead + c * left) + dx * turned
        constants[2, j] += dt * constants[3, j]
        constants[3, j] += params.bias_gain * (wheels - constants[3, j])
    _carry(noise, -dy, dx)
    noise[0, 0] += params.way_noise
    noise[1, 1] += params.way_noise
    noise[2, 2] += params.turn_noise


@loop(error_model="numpy")
def pose_covariance(
    params: UncertaintyParams, constants: Array, noise: Array, heading: float, twist: Planar, out: Array
) -> None:
    """Fill `out` (3, 3), m^2, m rad, rad^2, with the covariance of the pose while the base moves with a twist.

    Wheels that push creep in proportion to their force: on the way to a velocity they lag behind by a length in
    proportion to it, and make it up in braking.
    """
    s, c = sincos(heading)
    x, y = c * twist.x - s * twist.y, s * twist.x + c * twist.y
    lag = (params.force_creep * x, params.force_creep * y, 0.0)
    for i in range(3):
        for k in range(3):
            total = noise[i, k]
            for j in range(CONSTANTS):
                a, b = constants[i, j], constants[k, j]
                total += (a + lag[i]) * (b + lag[k]) if j == PUSH else a * b
            out[i, k] = total


@loop(error_model="numpy")
def _carry(P: Array, by_x: float, by_y: float) -> None:
    """`P <- F P F^T` with F the identity and a heading's effect on x and y beside it."""
    xt, yt, t = P[0, 2], P[1, 2], P[2, 2]
    P[0, 0] += by_x * (2.0 * xt + by_x * t)
    P[1, 1] += by_y * (2.0 * yt + by_y * t)
    P[0, 1] += by_x * yt + by_y * xt + by_x * by_y * t
    P[1, 0] = P[0, 1]
    P[0, 2] = P[2, 0] = xt + by_x * t
    P[1, 2] = P[2, 1] = yt + by_y * t
