"""Velocity of a base whose wheels all skid in curves: the slip at which friction makes the measured acceleration."""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.trace.code.loops import loop

__all__ = ["SkidParams", "skid_twist"]

MOST_STEP = 0.05  # m/s, of one iteration
ITERATIONS = 3  # a millisecond; it begins where the last one ended


class SkidParams(NamedTuple):
    """Driven wheels of a skid steer, all along x; n is 0 where there are none."""

    wheels: Array  # (n, 3) where they stand, m, and largest friction force over the base's mass, m/s^2
    soft: float  # m/s of slip, at which friction begins to saturate
    com_x: float  # m
    com_y: float


@loop(error_model="numpy")
def skid_twist(params: SkidParams, rims: Array, before: Planar, turn: float, ax: float, ay: float) -> Planar:
    """Twist (base_link) at which the wheels' friction makes the measured acceleration (m/s^2) at base_link.

    Parameters
    ----------
    rims
        Speeds (n,) of the rims, m/s.
    before
        The last twist, from which it is searched.
    turn
        Measured turning rate, rad/s.

    Notes
    -----
    Slip of wheel i: `s_i = (m_i - v_x + w y_i, -v_y - w x_i)`. Friction along it, `g_i s/sqrt(|s|^2 + s_0^2)`, is
    Coulomb's, smoothed; `sum_i f_i = a`: least of the convex `sum_i g_i sqrt(|s_i|^2 + s_0^2) + a . v` by Newton's
    method. In curves the base drifts outwards, and its centre of rotation wanders with speed and acceleration, which
    an effective track alone does not tell (Mandow et al., IROS 2007; Martinez et al., IJRR 24, 2005).
    """
    ax, ay = ax - turn * turn * params.com_x, ay - turn * turn * params.com_y
    vx, vy, s0 = before.x, before.y, params.soft
    cost = _dissipation(params, rims, vx, vy, turn, ax, ay)
    for _ in range(ITERATIONS):
        fx, fy, xx, xy, yy, secant = -ax, -ay, 0.0, 0.0, 0.0, 0.0
        for i in range(len(params.wheels)):
            along = rims[i] - vx + turn * params.wheels[i, 1]
            across = -vy - turn * params.wheels[i, 0]
            size = math.sqrt(along * along + across * across + s0 * s0)
            g = params.wheels[i, 2] / size
            fx += g * along
            fy += g * across
            k = g / (size * size)
            xx += k * (across * across + s0 * s0)
            yy += k * (along * along + s0 * s0)
            xy -= k * along * across
            secant += g
        determinant = xx * yy - xy * xy
        dx, dy = (yy * fx - xy * fy) / determinant, (xx * fy - xy * fx) / determinant
        part = MOST_STEP / max(math.sqrt(dx * dx + dy * dy), MOST_STEP)
        dx, dy = part * dx, part * dy
        after = _dissipation(params, rims, vx + dx, vy + dy, turn, ax, ay)
        if after > cost:  # Newton's step is too long where wheels slide: the secants' never is
            dx, dy = fx / secant, fy / secant
            part = MOST_STEP / max(math.sqrt(dx * dx + dy * dy), MOST_STEP)
            dx, dy = part * dx, part * dy
            after = _dissipation(params, rims, vx + dx, vy + dy, turn, ax, ay)
        vx, vy, cost = vx + dx, vy + dy, after
    return Planar(vx, vy, turn)


@loop(error_model="numpy")
def _dissipation(params: SkidParams, rims: Array, vx: float, vy: float, turn: float, ax: float, ay: float) -> float:
    """Friction's power over the mass, smoothed, and that of the acceleration: least at the twist that is looked for."""
    total = ax * vx + ay * vy
    for i in range(len(params.wheels)):
        along = rims[i] - vx + turn * params.wheels[i, 1]
        across = -vy - turn * params.wheels[i, 0]
        total += params.wheels[i, 2] * math.sqrt(along * along + across * across + params.soft * params.soft)
    return total
