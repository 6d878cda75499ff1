"""Compiled steps of the loops on a base: numbers and arrays in, numbers out; nothing is checked or allocated.

A base comes in as `rows` (m, 3): rim speed (m/s) of each driven wheel per (vx, vy, w), so that `rows^T f` is the
force (N, N, N m) of rim forces f on it. Wheels count by `weights` (m,), 0: left out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.arrays import Array
from holonom.trace.code.compiled import select, sincos
from holonom.trace.code.loops import loop

__all__ = [
    "BLIND",
    "JAMMED",
    "OFF",
    "OPEN",
    "WORKS",
    "EstimateParams",
    "KeepingParams",
    "Planar",
    "Suspicion",
    "TractionParams",
    "WatchParams",
    "estimate_step",
    "ground_speed",
    "keeping_step",
    "pose_step",
    "reference_at",
    "traction_step",
    "wanted_acceleration",
    "watch_step",
    "watch_verdict",
    "within_slip",
]


WORKS, OPEN, JAMMED, BLIND, OFF = 0, 1, 2, 3, 4
"""What the watch says of a motor."""
LEAKING = 0.1  # part of the modelled current, from which on current flows
MOST_BIAS = 0.02  # rad/s, of a difference between gyro and wheels that counts for the gyro's zero


class Planar(NamedTuple):
    """A pose (m, m, rad), a twist (m/s, m/s, rad/s), an acceleration or a wrench: two parts and a turn."""

    x: float
    y: float
    turn: float


class KeepingParams(NamedTuple):
    """Path keeping: gains in 1/s and 1/s^2, limits in m/s, rad/s, m/s^2, rad/s^2; sample time."""

    dt: float
    position_gain: float
    position_integral: float
    heading_gain: float
    heading_integral: float
    velocity_gain: float
    turn_rate_gain: float
    max_correction: float
    max_turn_correction: float
    max_acceleration: float
    max_turn_acceleration: float


class EstimateParams(NamedTuple):
    """Velocity estimate: part of the wheels' word taken each sample, limits of that (m/s^2), gyro bias gain."""

    dt: float
    gain: float
    max_pull: float
    bias_gain: float


class TractionParams(NamedTuple):
    """Traction control: slip (m/s) that is left alone, the largest wanted; cut and recovery of force, 1/s."""

    dt: float
    free_slip: float
    max_slip: float
    cut_rate: float
    recovery_rate: float


class WatchParams(NamedTuple):
    """Motor watch: currents (A), part of the current that must flow, speeds (rad/s), times (s), doubt."""

    dt: float
    least_current: float
    least_part: float
    standstill: float
    least_reference: float
    patience: float
    jam_patience: float
    holding_current: float
    doubt: float


class Suspicion(NamedTuple):
    """Time (s) for which a motor drew no current where it must, stood where it must not, turned uncounted."""

    open: float
    jam: float
    blind: float


@loop(error_model="numpy")
def keeping_step(
    params: KeepingParams, reference: Array, pose: Planar, turn_rate: float, integral: Planar, before: Planar
) -> tuple[Planar, Planar, Planar]:
    """Path keeping: the twist to command, the acceleration to feed forward (both in base_link), the next integral.

    Parameters
    ----------
    reference
        (9,): pose in the world; twist in the base_link of that pose; acceleration of the centre in the same axes, and
        of the heading.
    pose, turn_rate
        Where the base believes to be; its turning rate, rad/s.
    integral
        Integral of the pose error times its gain, world axes (m/s, m/s, rad/s).
    before
        The last command, which the acceleration limit counts from.

    Notes
    -----
    `u = R(e_theta) u_ref + K e + I`: the reference twist turned into the true heading, plus PI on the pose error in
    robot axes (Kanayama's error coordinates). The correction is limited, and the integral takes no more than that.
    """
    s, c = sincos(pose.turn)
    wx, wy = reference[0] - pose.x, reference[1] - pose.y
    turn = reference[2] - pose.turn
    turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    dt = params.dt
    ix, iy = _shorten(
        integral.x + dt * params.position_integral * wx, integral.y + dt * params.position_integral * wy,
        params.max_correction,
    )  # fmt: skip
    it = _clip(integral.turn + dt * params.heading_integral * turn, params.max_turn_correction)
    px, py = params.position_gain * wx + ix, params.position_gain * wy + iy
    px, py = _shorten(c * px + s * py, c * py - s * px, params.max_correction)
    pt = _clip(params.heading_gain * turn + it, params.max_turn_correction)
    e, d = sincos(turn)
    ux, uy = d * reference[3] - e * reference[4] + px, e * reference[3] + d * reference[4] + py
    ut = reference[5] + pt
    b = dt * turn_rate
    bx, by = before.x + b * before.y, before.y - b * before.x  # the last command, in axes that turned since
    dx, dy = _shorten(ux - bx, uy - by, dt * params.max_acceleration)
    command = Planar(bx + dx, by + dy, before.turn + _clip(ut - before.turn, dt * params.max_turn_acceleration))
    ahead = Planar(d * reference[6] - e * reference[7], e * reference[6] + d * reference[7], reference[8])
    return command, ahead, Planar(ix, iy, it)


@loop(error_model="numpy")
def wanted_acceleration(params: KeepingParams, command: Planar, twist: Planar, ahead: Planar) -> Planar:
    """Acceleration (base_link axes) that the drive forces aim at: fed forward plus velocity error, limited."""
    ax, ay = _shorten(
        ahead.x + params.velocity_gain * (command.x - twist.x),
        ahead.y + params.velocity_gain * (command.y - twist.y),
        params.max_acceleration,
    )
    turn = _clip(ahead.turn + params.turn_rate_gain * (command.turn - twist.turn), params.max_turn_acceleration)
    return Planar(ax, ay, turn)


@loop(error_model="numpy")
def reference_at(reference: Array, phase: float, rate: float, change: float, out: Array) -> None:
    """Fill `out` (9,) with a reference (N, 9) at a phase in samples that advances by `rate`, which changes (1/s)."""
    k = min(int(phase), reference.shape[0] - 1)
    after = min(k + 1, reference.shape[0] - 1)
    part = phase - k
    for j in range(9):
        out[j] = reference[k, j] + part * (reference[after, j] - reference[k, j])
    for j in range(3):
        out[6 + j] = rate * rate * out[6 + j] + change * out[3 + j]
        out[3 + j] *= rate


@loop(error_model="numpy")
def estimate_step(
    params: EstimateParams,
    rows: Array,
    weights: Array,
    rims: Array,
    twist: Planar,
    bias: float,
    rate: float,
    acceleration: Planar,
) -> tuple[Planar, float]:
    """Twist and gyro bias one sample later, from gyro, accelerometers and those wheels whose weight is not 0.

    The last velocity is carried along with the measured acceleration (base_link, m/s^2) and turns under the base;
    the trusted wheels, with the gyro's rate (rad/s) put in, pull at it with a limited acceleration. A wheel
    that spins can thus not run away with the estimate before it is found out.
    """
    dt = params.dt
    w = rate - bias
    vx = twist.x + dt * (acceleration.x + w * twist.y)
    vy = twist.y + dt * (acceleration.y - w * twist.x)
    xx = yy = xy = bx = by = along = square = 0.0
    for i in range(rows.shape[0]):
        p, q, g = rows[i, 0], rows[i, 1], weights[i]
        left = rims[i] - p * vx - q * vy - rows[i, 2] * w
        xx += g * p * p
        yy += g * q * q
        xy += g * p * q
        bx += g * p * left
        by += g * q * left
        along += g * rows[i, 2] * left
        square += g * rows[i, 2] * rows[i, 2]
    determinant = xx * yy - xy * xy
    if determinant > 1e-9:
        dx, dy = (yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant
        dx, dy = _shorten(params.gain * dx, params.gain * dy, dt * params.max_pull)
        vx += dx
        vy += dy
    if square > 1e-12:
        bias -= params.bias_gain * _clip(along / square, MOST_BIAS)
    return Planar(vx, vy, w), bias


@loop(error_model="numpy")
def pose_step(pose: Planar, twist: Planar, dt: float) -> Planar:
    """Dead reckoning: a constant twist (base_link) along its chord, at the mean heading, shortened as the arc's."""
    half = 0.5 * dt * twist.turn
    s, c = sincos(pose.turn + half)
    chord = dt * (1.0 - half * half / 6.0)
    return Planar(
        pose.x + chord * (c * twist.x - s * twist.y),
        pose.y + chord * (s * twist.x + c * twist.y),
        pose.turn + dt * twist.turn,
    )


@loop(error_model="numpy")
def ground_speed(rows: Array, wheel: int, twist: Planar) -> float:
    """Rim speed (m/s) of a wheel that does not slip while the base has a twist."""
    return rows[wheel, 0] * twist.x + rows[wheel, 1] * twist.y + rows[wheel, 2] * twist.turn


@loop(error_model="numpy")
def traction_step(params: TractionParams, cut: float, slip: float, force: float) -> float:
    """Part (0 to 1) of the drive force that a wheel may use next, from its estimated slip (m/s) and last force.

    Slip in the direction of the force beyond what is left alone takes force away, the faster the more of it; below
    it force comes back slowly.
    """
    excess = select(force >= 0.0, slip, -slip) - params.free_slip
    span = params.max_slip - params.free_slip
    less = cut - params.dt * params.cut_rate * min(excess / span, 1.0)
    more = cut + params.dt * params.recovery_rate
    return select(excess > 0.0, max(less, 0.0), min(more, 1.0))


@loop(error_model="numpy")
def within_slip(params: TractionParams, wanted: float, ground: float) -> float:
    """Rim speed (m/s) to command: the wanted one, no further from the floor's than the largest slip."""
    return min(max(wanted, ground - params.max_slip), ground + params.max_slip)


@loop(error_model="numpy")
def watch_step(
    params: WatchParams,
    before: Suspicion,
    measured: float,
    modelled: float,
    speed: float,
    reference: float,
    explained: bool = False,
    hidden: float = 0.0,
) -> Suspicion:
    """Evidence against a motor one sample later; `watch_verdict` says what it amounts to.

    Currents in A: what the shunt measures, and what the armature must draw at the commanded voltage and the measured
    speed. No current where there must be some: the winding is open, whether it turns or not. Current flows and the
    motor stands (speeds in rad/s) against the command: it is jammed. That is weaker evidence, by the square, the less
    current flows of what the floor could hold, and weaker where something else may explain a standing wheel
    (`explained`: other wheels slip, so that the base itself moves otherwise than told). Other evidence takes time back;
    no current asked for is none. A motor that stands by its encoder and turns by its back-emf (`hidden`, rad/s more
    than the encoder says) is counted no more.
    """
    if abs(modelled) <= params.least_current:
        return before
    uncounted = abs(speed) < params.standstill and abs(hidden) > params.least_reference
    if uncounted and abs(measured) > LEAKING * abs(modelled):
        return Suspicion(max(before.open - params.dt, 0.0), before.jam, before.blind + params.dt)
    if abs(measured) < params.least_part * abs(modelled):
        return Suspicion(before.open + params.dt, before.jam, before.blind)
    opened = max(before.open - params.dt, 0.0)
    if abs(reference) <= params.least_reference:
        return Suspicion(opened, before.jam, 0.0)
    if abs(speed) < params.standstill:
        part = min(abs(measured) / params.holding_current, 1.0)
        return Suspicion(opened, before.jam + (params.doubt if explained else 1.0) * part * part * params.dt, 0.0)
    return Suspicion(opened, 0.0, 0.0)


@loop(error_model="numpy")
def watch_verdict(params: WatchParams, suspicion: Suspicion) -> int:
    """What is wrong with a motor: `WORKS`, `OPEN` (no current, it turns freely), `JAMMED`, `BLIND`."""
    if suspicion.open >= params.patience:
        return OPEN
    if suspicion.blind >= params.jam_patience:
        return BLIND
    return JAMMED if suspicion.jam >= params.jam_patience else WORKS


@loop(error_model="numpy")
def _shorten(x: float, y: float, limit: float) -> tuple[float, float]:
    size = math.sqrt(x * x + y * y)
    if size <= limit:
        return x, y
    return x * limit / size, y * limit / size


@loop(error_model="numpy")
def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
