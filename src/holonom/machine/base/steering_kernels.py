"""Steered wheels as a controller sees them: rows at the measured angles, angles to ask for, shares of force."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.base.shaping_kernels import AxisShape, ShapingParams, shaping_step
from holonom.control.path_laws.contract import REST
from holonom.devices.drive_signals import WheelSignals
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import WIDTH

__all__ = [
    "SteeredParams",
    "allowed",
    "bend",
    "eased",
    "look_at",
    "look_at_wheels",
    "readiness",
    "ready",
    "rim_change",
    "set_off",
    "share_along",
    "share_at_pivots",
    "steer",
    "steer_along",
    "swing",
]

STILL = 1e-3  # m/s of a contact, below which a wheel is not steered
CRAWL = 0.03  # m/s of the reference, below which wheels are steered for it, not for its errors
SEEN = (
    0.1  # of what a castor's angle is off from how it was asked to swing, that is believed at once: counts are coarse
)
SET_OFF = 0.97  # readiness from which a base that stands drives on
ON_THE_SPOT = 1e6  # 1/m
VELOCITY, PATH = 1, 0
Integers = NDArray[np.int64]
Records = NDArray[np.void]


class SteeredParams(NamedTuple):
    """Wheels of a base that steers: n wheels, q of them steered; m driven rows, s directions in which none slides."""

    places: Array  # (n, 3) x, y, m, and heading at rest, rad
    limits: Array  # (n,) rad to either side; infinite: all around
    lanes: Integers  # (n,) where in the signals a steered wheel is; -1: it is not steered
    driven: Integers  # (m,) wheel of each driven row
    sliding: Integers  # (s,) wheel of each direction without sliding, then those of driven castors
    levers: Array  # (n,) m from pivot to contact of a driven castor; 0: of others
    pull: Array  # (3, 3) pivots' velocities squared, inverted, where all driven wheels are castors; zeros: they are not
    curvature: float  # 1/m of the tightest curve
    reach: float  # m to the farthest wheel
    turning: AxisShape  # of a wheel about its vertical axis: angle, rate, acceleration
    dt: float
    ahead: float  # s by which set-points look ahead: the lag of the steering motors


@loop(error_model="numpy")
def look_at_wheels(params: SteeredParams, signals: WheelSignals, work: Any, wheels: Records) -> None:
    """Fill the rows (m, 3) and (m + s, 3) of the constraints at the measured angles.

    The contact of a driven castor moves across it as its pivot does and as it swings: `n . v + d (w + delta') = 0`. How
    fast it swings is what it was asked for, corrected by where it is seen.
    """
    rows, estimate_rows = work.rows, work.estimate_rows
    m = len(params.driven)
    for i in range(m):
        x, y, s, c = _stance(params, signals, params.driven[i])
        rows[i, 0], rows[i, 1], rows[i, 2] = c, s, x * s - y * c
        wheel, lane = wheels[i // WIDTH], i % WIDTH
        wheel.rim_x[lane], wheel.rim_y[lane], wheel.rim_turn[lane] = rows[i, 0], rows[i, 1], rows[i, 2]
        estimate_rows[i] = rows[i]
    for j in range(len(params.sliding)):
        x, y, s, c = _stance(params, signals, params.sliding[j])
        lever, lane = params.levers[params.sliding[j]], params.lanes[params.sliding[j]]
        estimate_rows[m + j, 0], estimate_rows[m + j, 1], estimate_rows[m + j, 2] = -s, c, x * c + y * s + lever
        if lever != 0.0:
            asked = params.dt * work.steering_rates[lane]
            swung = asked + SEEN * (signals.turned[lane] - work.swung[lane] - asked)
            work.swung[lane] += swung
            work.swinging[j] = -lever * swung / params.dt


@loop(error_model="numpy", forceinline=True)
def _stance(params: SteeredParams, signals: WheelSignals, wheel: int) -> tuple[float, float, float, float]:
    """Place of a wheel, and sine and cosine of its heading."""
    lane = params.lanes[wheel]
    heading = params.places[wheel, 2]
    if lane >= 0:
        heading += signals.turned[lane]
    s, c = sincos(heading)
    return params.places[wheel, 0], params.places[wheel, 1], s, c


@loop(error_model="numpy")
def bend(params: SteeredParams, command: Planar) -> Planar:
    """The command on the tightest curve where it asks for a tighter one; one that turns on the spot drives any."""
    if params.curvature >= ON_THE_SPOT:
        return command
    most = params.curvature * math.sqrt(command.x * command.x + command.y * command.y)
    return Planar(command.x, command.y, min(max(command.turn, -most), most))


@loop(error_model="numpy")
def readiness(params: SteeredParams, twist: Planar, signals: WheelSignals) -> float:
    """Part (0 to 1) of a twist that is driven while wheels still turn: the fourth power of the worst cosine.

    A wheel that cannot be steered to the twist holds it back for good. Driven castors hold it back to how fast they can
    swing.
    """
    least = 1.0
    for i in range(len(params.lanes)):
        lane = params.lanes[i]
        vx, vy = twist.x - twist.turn * params.places[i, 1], twist.y + twist.turn * params.places[i, 0]
        square = vx * vx + vy * vy
        if lane >= 0 and square >= STILL * STILL:
            s, c = sincos(params.places[i, 2] + signals.turned[lane])
            along = c * vx + s * vy
            if params.levers[i] == 0.0:
                least = min(least, along * along / square)
            else:
                rate = abs((c * vy - s * vx) / params.levers[i] + twist.turn)
                least = min(least, math.sqrt(params.turning.speed / max(rate, params.turning.speed)))
    return least * least


@loop(error_model="numpy")
def steer(params: SteeredParams, twist: Planar, signals: WheelSignals, rates: Array) -> None:
    """Ask for the angles at which the wheels roll with a twist, nearest modulo half a turn to those asked for last.

    They change within rate and acceleration of the steering motors; `rates` (rad/s) are those of the set-points.
    """
    for i in range(len(params.lanes)):
        lane = params.lanes[i]
        if lane < 0 or params.levers[i] != 0.0:
            continue
        vx, vy = twist.x - twist.turn * params.places[i, 1], twist.y + twist.turn * params.places[i, 0]
        if vx * vx + vy * vy < STILL * STILL:
            rates[lane] = 0.0
            continue
        angle, limit = math.atan2(vy, vx) - params.places[i, 2], params.limits[i]
        near = signals.steering[lane] if limit > math.pi else 0.0
        angle -= math.pi * math.floor((angle - near) / math.pi + 0.5)
        signals.steering[lane], rates[lane] = shaping_step(
            params.dt, params.turning, signals.steering[lane], rates[lane], min(max(angle, -limit), limit)
        )


@loop(error_model="numpy")
def swing(params: SteeredParams, twist: Planar, signals: WheelSignals, rates: Array) -> None:
    """Ask driven castors for the rates with which they follow a twist: `delta' = -n . v / d - w` (`castor_rates`).

    A motor that follows an angle with a lag turns at the rate by which it is asked to be ahead after that lag.
    """
    for i in range(len(params.lanes)):
        lane, lever = params.lanes[i], params.levers[i]
        if lane < 0 or lever == 0.0:
            continue
        x, y, s, c = _stance(params, signals, i)
        across = c * (twist.y + twist.turn * x) - s * (twist.x - twist.turn * y)
        rate = min(max(-across / lever - twist.turn, -params.turning.speed), params.turning.speed)
        signals.steering[lane], rates[lane] = signals.turned[lane] + params.ahead * rate, rate


@loop(error_model="numpy")
def share_at_pivots(rows: Array, pull: Array, states: Records) -> None:
    """Share force on the base among the pivots of driven castors, least sum of squares; rims take what lies along them.

    Forces f = G N^-1 F with G the pivots' velocities per twist, N = G^T G (Holmberg & Khatib 2000); the motors at the
    pivots take what lies across.
    """
    for i in range(len(rows)):
        a, b, c = rows[i, 0], rows[i, 1], rows[i, 2]
        own, lane = states[i // WIDTH], i % WIDTH
        own.force_x[lane] = a * pull[0, 0] + b * pull[1, 0] + c * pull[2, 0]
        own.force_y[lane] = a * pull[0, 1] + b * pull[1, 1] + c * pull[2, 1]
        own.force_turn[lane] = a * pull[0, 2] + b * pull[1, 2] + c * pull[2, 2]


@loop(error_model="numpy")
def share_along(rows: Array, weights: Array, twist: Planar, states: Records) -> None:
    """Share force on the base among the wheels so that it does the work that it does along a twist.

    `f_i = g_i d_i (xi . F) / sum g d^2` with d the rims' speeds at the twist xi: at given angles a base moves one way.
    """
    square = 0.0
    for i in range(len(rows)):
        d = rows[i, 0] * twist.x + rows[i, 1] * twist.y + rows[i, 2] * twist.turn
        square += weights[i] * d * d
    if square < STILL * STILL:
        return
    for i in range(len(rows)):
        own, lane = states[i // WIDTH], i % WIDTH
        part = weights[i] * (rows[i, 0] * twist.x + rows[i, 1] * twist.y + rows[i, 2] * twist.turn) / square
        own.force_x[lane], own.force_y[lane], own.force_turn[lane] = (
            part * twist.x, part * twist.y, part * twist.turn
        )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def look_at(steered: SteeredParams | None, signals: WheelSignals, work: Any, wheels: Records) -> None:
    """`look_at_wheels` where there are any that steer."""
    if steered is not None:
        look_at_wheels(steered, signals, work, wheels)


@loop(error_model="numpy", forceinline=True)
def allowed(steered: SteeredParams | None, drivable: Array, command: Planar) -> Planar:
    """The command without what no steering makes wheels roll along."""
    x = drivable[0, 0] * command.x + drivable[0, 1] * command.y + drivable[0, 2] * command.turn
    y = drivable[1, 0] * command.x + drivable[1, 1] * command.y + drivable[1, 2] * command.turn
    turn = drivable[2, 0] * command.x + drivable[2, 1] * command.y + drivable[2, 2] * command.turn
    if steered is not None:
        return bend(steered, Planar(x, y, turn))
    return Planar(x, y, turn)


@loop(error_model="numpy", forceinline=True)
def ready(steered: SteeredParams | None, twist: Planar, signals: WheelSignals) -> float:
    """Part of a twist that may be driven while its wheels are still being steered to it."""
    if steered is not None:
        return readiness(steered, twist, signals)
    return 1.0


@loop(error_model="numpy", forceinline=True)
def eased(steered: SteeredParams | None, shaping: ShapingParams, before: Planar, twist: Planar, now: Array) -> Planar:
    """The way from the twist before to a twist that jumps as wheels get ready, as far as accelerations allow.

    All parts go alike, so that the curve stays one between the two; `now` (9,) gets the acceleration of that.
    """
    if steered is not None:
        x, y, turn, dt = twist.x - before.x, twist.y - before.y, twist.turn - before.turn, shaping.dt
        much = max(
            abs(x) / shaping.forwards.acceleration, abs(y) / shaping.sideways.acceleration,
            abs(turn) / shaping.turning.acceleration, dt,
        )  # fmt: skip
        part = dt / much
        twist = Planar(before.x + part * x, before.y + part * y, before.turn + part * turn)
        now[6] = part * x / dt - twist.turn * twist.y
        now[7] = part * y / dt + twist.turn * twist.x
        now[8] = part * turn / dt
    return twist


@loop(error_model="numpy", forceinline=True)
def steer_along(
    steered: SteeredParams | None, drivable: Array, path: Array, base: Any, command: Planar, ahead: Planar,
    signals: WheelSignals, work: Any, states: Records,
) -> None:  # fmt: skip
    """Steer for the twist that is to be, once the motors have followed; share force along it.

    What a twist along axes that turn changes by is the centre's acceleration less `w x v`. Velocities are steered for
    as they are asked for: what is driven of them waits for the wheels. On a path that hardly moves they are steered
    for the path, where it stands for how it goes on: at cusps wheels turn before the base drives on.
    """
    if steered is not None:
        t, w = steered.ahead, command.turn
        x = command.x + t * (ahead.x + w * command.y)
        y = command.y + t * (ahead.y - w * command.x)
        turn = w + t * ahead.turn
        if base.mode == VELOCITY:
            x, y = base.shaped_vx + t * base.shaped_ax, base.shaped_vy + t * base.shaped_ay
            turn = base.shaped_w + t * base.shaped_aw
        elif base.mode == PATH and _size(steered, path[_sample(path, base.phase)]) < CRAWL:
            next_twist = _coming(steered, path, base.phase)
            x, y, turn = next_twist.x, next_twist.y, next_twist.turn
        soon = allowed(steered, drivable, Planar(x, y, turn))
        steer(steered, soon, signals, work.steering_rates)
        swing(steered, command, signals, work.steering_rates)
        if steered.pull[0, 0] > 0.0:
            share_at_pivots(work.rows, steered.pull, states)
        else:
            share_along(work.rows, work.weights, soon, states)


@loop(error_model="numpy", forceinline=True)
def rim_change(steered: SteeredParams | None, wanted: Planar, twist: Planar) -> Planar:
    """What rims of steered wheels change by: the acceleration along axes that turn, `a - w x v` (`mobile.wheel_rates`).

    Bases that do not steer are fed the acceleration of the centre as it is.
    """
    if steered is not None:
        return Planar(wanted.x + twist.turn * twist.y, wanted.y - twist.turn * twist.x, wanted.turn)
    return wanted


@loop(error_model="numpy", forceinline=True)
def set_off(steered: SteeredParams | None, path: Array, base: Any, signals: WheelSignals) -> float:
    """1, or 0 where a path is about to drive on from rest and its wheels are still being steered."""
    go = 1.0
    if steered is not None:
        leaves = base.mode == PATH and base.pinned == 0 and _sets_off(steered, path, base.phase)
        if leaves and readiness(steered, _coming(steered, path, base.phase), signals) < SET_OFF:
            go = 0.0
    return go


@loop(error_model="numpy", forceinline=True)
def _sets_off(steered: SteeredParams, path: Array, phase: float) -> bool:
    """Whether a path stands and drives on with its next sample."""
    k = _sample(path, phase)
    return k < path.shape[0] - 1 and _size(steered, path[k]) <= REST < _size(steered, path[k + 1])


@loop(error_model="numpy")
def _coming(steered: SteeredParams, path: Array, phase: float) -> Planar:
    """The way on which the path is, as fast as `CRAWL`; where it stands, the one on which it goes on; 0 at its end."""
    k = _sample(path, phase)
    while k < path.shape[0] - 1 and _size(steered, path[k]) <= REST:
        k += 1
    size = _size(steered, path[k])
    if size <= REST:
        return Planar(0.0, 0.0, 0.0)
    return Planar(path[k, 3] * CRAWL / size, path[k, 4] * CRAWL / size, path[k, 5] * CRAWL / size)


@loop(error_model="numpy", forceinline=True)
def _sample(path: Array, phase: float) -> int:
    return min(int(phase), path.shape[0] - 1)


@loop(error_model="numpy", forceinline=True)
def _size(steered: SteeredParams, row: Array) -> float:
    """Speed, m/s, of a base and of its farthest wheel about it, together."""
    return math.sqrt(row[3] * row[3] + row[4] * row[4]) + steered.reach * abs(row[5])
