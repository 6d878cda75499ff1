"""Slip detection: by spare wheels, or by sensors of inertia where there are none; wheels and steering that are lost.

Velocity is carried along with the accelerometers (less their zero, which is learned) and turned with the gyro; wheels
that grip pull at it. A rim that is far from it slips: it changed its speed, and the base did not. Where all are far
from it accelerometers are believed for a while, then nothing tells.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.inertial_check import EVERY, CheckParams, PushParams
from holonom.control.base.kernels import OFF, WORKS, Planar
from holonom.devices.drive_signals import WheelSignals
from holonom.devices.transmission.kernels import friction_torque
from holonom.machine.base.params import BaseParams, Work
from holonom.machine.base.steering_kernels import SteeredParams
from holonom.mobile.drive.slip_kernels import AMBIGUOUS, NO_SLIP, SLIP, SlipState, slip_step
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH, packed

__all__ = [
    "check_inertia",
    "detect_slip",
    "drives_on",
    "members",
    "pin",
    "pinned",
    "watch_pushes",
    "watch_steering",
]

REST = 2e-3  # m/s of rims, below which a base stands
REST_TURN = 0.01  # rad/s
AT_REST = 10.0  # 1/s, how fast the accelerometers' zero is learned there
ASTRAY = 0.05  # rad that a steering motor may be off
HELD = 0.2  # s for which it does not move then, until it is stuck
LEAST_ARM = 0.2  # of the wheels' reach: a stuck wheel nearer to the axle through the middle lets no path be kept
MOST_TURN = 3.0  # rad/s that a base turns about a stuck wheel
PUSHES = 0.5  # part of what is asked, from which on a wheel pushes
DOUBTED = 5.0  # how much more a push says than none
FULL = 0.99  # of the supply, from which on a motor is at the end of its voltage
INDEPENDENT = 1e-3  # part of a row that others do not have
Records = NDArray[np.void]


@loop(error_model="numpy", forceinline=True)
def check_inertia(params: CheckParams | None, base: Any, work: Any) -> None:
    """Find wheels that slip where wheels alone do not tell."""
    if params is not None:
        _check(params, base, len(work.rows), work.estimate_rows, work.gripping, work.rims)


@loop(error_model="numpy")
def _check(params: CheckParams, base: Any, m: int, rows: Array, gripping: Array, rims: Array) -> None:
    dt, w = params.dt, base.gyro - base.gyro_bias
    given_up = base.blind | base.loose | base.jams
    ax, ay = base.imu_x - base.check_zero_x, base.imu_y - base.check_zero_y
    vx = base.check_vx + dt * (ax + w * base.check_vy)
    vy = base.check_vy + dt * (ay - w * base.check_vx)
    over, grip, fastest = 0, 0, 0.0
    x = y = square = all_x = all_y = whole = 0.0
    for i in range(len(rows)):
        if i < m and (given_up >> i) & 1 == 1:
            continue
        p, q, t = rows[i, 0], rows[i, 1], rows[i, 2]
        left = (gripping[i] if i < m else rims[i]) - p * vx - q * vy - t * w
        all_x, all_y, whole = all_x + p * left, all_y + q * left, whole + p * p + q * q
        if i < m:
            fastest = max(fastest, abs(gripping[i]))
            if abs(left) > params.bound + params.drift * base.check_since + params.turn * abs(t):
                over |= 1 << i
                continue
            grip += 1
        x, y, square = x + p * left, y + q * left, square + p * p + q * q
    if square > 0.0:
        vx, vy = vx + params.blend * dt * x / square, vy + params.blend * dt * y / square
    if over == 0 and square > 0.0:
        base.check_zero_x -= params.learning * dt * x / square
        base.check_zero_y -= params.learning * dt * y / square
    if fastest < REST and abs(w) < REST_TURN:
        base.check_zero_x += AT_REST * dt * (base.imu_x - base.check_zero_x)
        base.check_zero_y += AT_REST * dt * (base.imu_y - base.check_zero_y)
        vx = vy = 0.0
    most = params.persistence + params.release
    base.check_raised = min(base.check_raised + 1, most) if over != 0 else max(base.check_raised - 1, 0)
    raised = base.check_raised >= params.persistence
    base.check_since = base.check_since + dt if raised and grip == 0 else 0.0
    if base.check_since > params.patience and whole > 0.0:  # the accelerometers alone tell nothing any more
        vx, vy = vx + all_x / whole, vy + all_y / whole
        base.check_raised, base.check_since, raised = 0, 0.0, False
    base.check_vx, base.check_vy = vx, vy
    sure = raised and base.check_since <= 0.5 * params.patience
    base.status = NO_SLIP if not raised else SLIP if sure else AMBIGUOUS
    if over != 0 or not raised:
        base.flagged = over if sure else 0


@loop(error_model="numpy", forceinline=True)
def watch_pushes(params: PushParams | None, base: Any, wheels: Records, states: Records, m: int) -> None:
    """Give up wheels that push nothing of what is asked, or slip for good, while others push."""
    if params is not None:
        base.unwatched += 1
        if base.unwatched >= EVERY:
            base.unwatched = 0
            _watch_pushes(params, base, wheels, states, m)


@loop(error_model="numpy")
def _watch_pushes(params: PushParams, base: Any, wheels: Records, states: Records, m: int) -> None:
    """`f = (tau - J dw/dt) / r`: what a motor's torque does not turn its own wheel with, the wheel pushes with.

    A wheel that is off turns with all of it, whichever way it is asked to push; one of several that push against each
    other may push nothing one way, but not both. A motor at the end of its voltage tells nothing.
    """
    if base.dead != 0 or base.lodged != 0 or base.astray != 0:  # what is asked of wheels then is not what they can
        return
    for k in range(len(wheels)):
        wheel, own = packed(wheels[k]), packed(states[k])
        torque = wheel.torque_constant * own.measured_current - friction_torque(wheel.friction, own.seen_speed)
        turning = wheel.inertia * own.seen_load / wheel.gear.ratio
        own.pushed = (torque * wheel.gear.ratio * wheel.gear.efficiency - turning) / wheel.radius
    pushing = 0  # wheels that push as they are asked
    for i in range(m):
        wheel, own, lane = wheels[i // WIDTH], states[i // WIDTH], i % WIDTH
        asked, pushed = abs(own.asked[lane]), abs(own.pushed[lane])
        least = params.least_push * wheel.max_force[lane]
        slips = (base.flagged >> i) & 1 == 1 and base.flagged != (1 << m) - 1  # all at once are on ice
        pushing |= 1 << i if asked > least and pushed > PUSHES * asked and not slips else 0
        own.slips_for[lane] = max(own.slips_for[lane] + (params.dt if slips and pushed < least else -params.dt), 0.0)
    grips = base.status != SLIP and base.status != AMBIGUOUS
    for i in range(m):
        wheel, own, lane = wheels[i // WIDTH], states[i // WIDTH], i % WIDTH
        asked, least = own.asked[lane], params.least_push * wheel.max_force[lane]
        told = grips and abs(asked) > least and abs(own.voltage[lane]) < FULL * wheel.armature.max_voltage[lane]
        if (pushing >> i) & 1 == 1:
            own.idle_ahead[lane] = max(own.idle_ahead[lane] - DOUBTED * params.dt, 0.0)
            own.idle_back[lane] = max(own.idle_back[lane] - DOUBTED * params.dt, 0.0)
        elif told and pushing != 0 and abs(own.pushed[lane]) < params.push * abs(asked):  # else all may be on ice
            own.idle_ahead[lane] += params.dt if asked > 0.0 else 0.0
            own.idle_back[lane] += params.dt if asked < 0.0 else 0.0
        idle = min(own.idle_ahead[lane], own.idle_back[lane]) > params.idle
        if own.lost[lane] == WORKS and (idle or own.slips_for[lane] > params.loose):
            own.lost[lane] = OFF


@loop(error_model="numpy", forceinline=True)
def drives_on(rows: Array, drivable: Array, weights: Array, lever: float) -> int:
    """How many motions of a base the wheels that count still drive, of those that its wheels allow."""
    basis = np.zeros((3, 3))
    count = 0
    for i in range(rows.shape[0]):
        if weights[i] <= 0.0 or count == 3:
            continue
        size = 0.0
        for j in range(3):
            basis[count, j] = (
                rows[i, 0] * drivable[0, j] + rows[i, 1] * drivable[1, j] + rows[i, 2] * drivable[2, j]
            ) / (lever if j == 2 else 1.0)
            size += basis[count, j] * basis[count, j]
        left = 0.0
        for k in range(count):
            along = 0.0
            for j in range(3):
                along += basis[k, j] * basis[count, j]
            for j in range(3):
                basis[count, j] -= along * basis[k, j]
        for j in range(3):
            left += basis[count, j] * basis[count, j]
        if left > INDEPENDENT * INDEPENDENT * size and size > 0.0:
            for j in range(3):
                basis[count, j] /= math.sqrt(left)
            count += 1
    return count


@loop(error_model="numpy", forceinline=True)
def watch_steering(steered: SteeredParams | None, base: Any, signals: WheelSignals, held: Array) -> None:
    """Find steering motors that do not move though they should: a set in `base.lodged`; `held` (n, 2): angle, since."""
    base.astray = 0
    if steered is not None:
        for i in range(len(steered.lanes)):
            lane = steered.lanes[i]
            if lane < 0:
                continue
            astray = abs(signals.steering[lane] - signals.turned[lane]) > ASTRAY
            if not astray or signals.turned[lane] != held[i, 0]:
                held[i, 0], held[i, 1] = signals.turned[lane], 0.0
                base.astray = 1 if astray else base.astray
                continue
            base.astray = 1
            held[i, 1] += steered.dt
            if held[i, 1] > HELD:
                base.lodged |= 1 << i


@loop(error_model="numpy", forceinline=True)
def pin(steered: SteeredParams | None, base: Any, signals: WheelSignals, row: Array) -> bool:
    """Whether the path can be kept with the wheel that is stuck, whose direction without sliding goes to `row` (3,)."""
    if steered is not None:
        for i in range(len(steered.lanes)):
            if base.lodged == 1 << i:
                x, y = steered.places[i, 0], steered.places[i, 1]
                s, c = sincos(steered.places[i, 2] + signals.turned[steered.lanes[i]])
                row[0], row[1], row[2] = -s, c, x * c + y * s
                return abs(row[2]) > LEAST_ARM * steered.reach
    return False


@loop(error_model="numpy", forceinline=True)
def pinned(base: Any, row: Array, wanted: Planar) -> Planar:
    """The wanted motion, turned as the wheel that is stuck rolls; slower where it would have to turn too fast.

    The middle moves as asked; the base turns as a trailer does about the hitch that pulls it.
    """
    if base.pinned == 0:
        return wanted
    turn = -(row[0] * wanted.x + row[1] * wanted.y) / row[2]
    part = min(1.0, MOST_TURN / max(abs(turn), 1e-9))
    return Planar(part * wanted.x, part * wanted.y, part * turn)


@loop(error_model="numpy", forceinline=True)
def detect_slip(params: BaseParams, base: Any, work: Work) -> None:
    """Ask the slip detector, but while all wheels are known to grip."""
    if params.detect and not (base.steady != 0 and _square(params.residual, work.gripping) <= params.quiet):
        if base.steady != 0:
            _keep_slip(base.slip, _no_slip(params.inverse, work.last))
        work.acceleration[0], work.acceleration[1] = base.imu_x, base.imu_y
        wheels = work.gripping[: len(work.rows)]
        after, found = slip_step(params.slip, base.slip, wheels, base.gyro - base.gyro_bias, work.acceleration)
        _keep_slip(base.slip, after)
        base.status, base.flagged = found.status, found.named
        base.steady = 1 if params.quiet >= 0.0 and after.level == 0 and after.held_slack == 0.0 else 0
    work.last[:] = work.gripping


@loop(error_model="numpy", forceinline=True)
def _square(residual: Array, rims: Array) -> float:
    """Square sum, (m/s)^2, of what no twist explains of rim speeds."""
    total = 0.0
    for i in range(len(residual)):
        left = 0.0
        for j in range(len(residual)):
            left += residual[i, j] * rims[j]
        total += left * left
    return total


@loop(error_model="numpy", forceinline=True)
def _no_slip(inverse: Array, rims: Array) -> SlipState:
    """Return the state that `slip_step` takes in silence: it trusts the twist of all wheels."""
    vx, vy, rw = 0.0, 0.0, 0.0
    for i in range(inverse.shape[1]):
        vx += inverse[0, i] * rims[i]
        vy += inverse[1, i] * rims[i]
        rw += inverse[2, i] * rims[i]
    return SlipState(vx, vy, rw, 0.0, 0.0, vx, vy, rw, 0.0, 0.0, 0, False, 0, 0, 0, 0, 0, False)


@loop(error_model="numpy", forceinline=True)
def _keep_slip(own: Any, after: SlipState) -> None:
    """Remember what slip detection carries from sample to sample."""
    own.vx, own.vy, own.rw, own.slack, own.angular_slack = (
        after.vx, after.vy, after.rw, after.slack, after.angular_slack,
    )  # fmt: skip
    own.held_x, own.held_y, own.held_rw = after.held_x, after.held_y, after.held_rw
    own.held_slack, own.held_angular_slack = after.held_slack, after.held_angular_slack
    own.level, own.raised, own.pending, own.agreed = after.level, after.raised, after.pending, after.agreed
    own.named, own.doubt, own.side, own.mixed = after.named, after.doubt, after.side, after.mixed


@loop(error_model="numpy", forceinline=True)
def members(states: Records, m: int, what: int) -> int:
    """Set of the wheels of which the watch says so."""
    found = 0
    for i in range(m):
        if states[i // WIDTH].lost[i % WIDTH] == what:
            found |= 1 << i
    return found
