"""Time-optimal speed along a given path: motors, friction, wheel loads, steering rate, speed (specification 06)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite, is_number, shown
from holonom.errors import InputError, MotionError, OutOfLimits, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.limits import DriveLimits
from holonom.mobile.drive.speed_kernels import Demands, speed_pass
from holonom.model.gravity import GRAVITY

__all__ = ["SpeedProfile", "speed_profile"]

_TABLE = 4001  # rim speeds at which the motors' forces are looked up
_JUMP = 1e-9


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """When a base is where on a path.

    Attributes
    ----------
    way
        (n,) along the path, m, never back.
    speed, acceleration
        (n,) of the way, m/s and m/s2, at least 0 and either sign; acceleration is that until the next place.
    time
        (n,) s from the start. Where the base stops on its way and its wheels are steered anew, the place stands twice,
        and time passes between.
    """

    way: Array
    speed: Array
    acceleration: Array
    time: Array


def speed_profile(
    base: WheelBase, way: ArrayLike, curvature: ArrayLike, drive: DriveLimits, *, direction: ArrayLike = 1.0,
    max_speed: float = math.inf, steering_rate: float = math.inf,
) -> SpeedProfile:  # fmt: skip
    """Fastest speed along a path from rest to rest that motors, floor and steering allow; the heading is the tangent.

    Parameters
    ----------
    base
        Its wheels, mass and inertia.
    way
        (n,) places along the path, m, never back; one twice where curvature or direction jumps.
    curvature
        (n,) 1/m: turn of the base per way.
    drive
        What motors and floor give (`drive_limits`).
    direction
        1 forwards, -1 backwards; one number or (n,).
    max_speed
        m/s along the path.
    steering_rate
        rad/s of steered wheels.

    Returns
    -------
    SpeedProfile

    Raises
    ------
    ShapeError, OutOfLimits
    InputError
        A path sharper than the base can turn: where, and its smallest radius. A base with driven castors.
    MotionError
        A place where the base cannot even stand, or from which it cannot drive on.

    Notes
    -----
    Wanted accelerations of the centre of mass and the heading are linear in a and z = v^2 (Bobrow, Dubowsky & Gibson
    1985). Rim forces of least square sum make what of them the wheels' constraints leave free; what is across is held
    by the wheels that do not slide, each in proportion to its load: each wheel's two forces lie within its friction
    circle. Loads move with the acceleration; none is lifted (for a body on three wheels: it does not tip). Motors as
    `DriveLimits.motor_limits` at the rim's speed; steering rate by the change of the wheels' angles along the way. The
    fastest speed is found by a backward and a forward pass over the places (Pham & Pham, TOPP-RA, 2018), so its error
    falls with their distance. Curvature that jumps cannot be driven: the base stops there, and steers.
    """
    s, k, sign = _checked(base, way, curvature, direction, max_speed, steering_rate)
    repeated = np.diff(s) <= 0.0
    jump = np.flatnonzero(repeated & ((np.abs(np.diff(k)) > _JUMP) | (np.diff(sign) != 0.0)))
    pieces = np.split(np.arange(len(s)), jump + 1)
    twist = np.column_stack([sign, np.zeros_like(s), k])
    steering = _steering(base, s, twist)
    bend, turning = np.zeros_like(k), np.zeros_like(steering)
    for piece in pieces:
        bend[piece], turning[piece] = _slope(s[piece], k[piece]), _slope(s[piece], steering[piece])
    demands = _demands(base, drive, twist, bend, steering, sign)
    cap = _cap(demands, max_speed, steering_rate, turning)
    cap[[0, -1]] = 0.0
    cap[jump] = cap[jump + 1] = 0.0
    square = np.zeros_like(s)
    stuck = speed_pass(demands._replace(cap=cap), np.diff(s), square)
    if stuck >= 0:
        raise MotionError(
            f"base {base.name!r} cannot drive on {s[stuck]:.4g} m along the path: no acceleration is within motors, "
            "friction and wheel loads there; state a stronger drive, or a flatter curve"
        )
    return _in_time(s, square, jump, steering, steering_rate)


def _checked(
    base: WheelBase, way: ArrayLike, curvature: ArrayLike, direction: ArrayLike, max_speed: float, rate: float
) -> tuple[Array, Array, Array]:
    s, k = finite("way", way), finite("curvature", curvature)
    sign = finite("direction", direction)
    if s.ndim != 1 or len(s) < 3 or k.shape != s.shape or sign.shape not in ((), s.shape):
        raise ShapeError(
            f"speed_profile: way has shape {s.shape}, curvature {k.shape}, direction {sign.shape}; each must be (n,), "
            "n at least 3, direction may be a number"
        )
    if (np.diff(s) < 0.0).any() or s[-1] <= s[0]:
        raise OutOfLimits("speed_profile: way must never go back, and lead somewhere; give places in their order")
    if not np.isin(sign, (1.0, -1.0)).all():
        raise OutOfLimits("speed_profile: direction must be 1 (forwards) or -1 (backwards)")
    for name, value in (("max_speed", max_speed), ("steering_rate", rate)):
        if not (is_number(value) and value > 0.0):
            raise OutOfLimits(f"speed_profile: {name} is {shown(value)}; it must be a number above 0")
    if base.mass is None:
        raise InputError(f"base {base.name!r} states no mass; give it one, kg (mass=)")
    castors = [wheel.name for wheel in base.wheels if wheel.powered_castor]
    if castors:
        raise InputError(
            f"base {base.name!r} has driven castors ({', '.join(castors)}), whose angles depend on where they came "
            "from: no profile is made for them; plan its path with limits of speed and acceleration (plan_path)"
        )
    return s - s[0], k, np.broadcast_to(sign, s.shape)


def _steering(base: WheelBase, s: Array, twist: Array) -> Array:
    """Steering angles (n, k), rad, without jumps of half a turn.

    Raises
    ------
    InputError
    """
    least = base.turning_radius
    sharpest = int(np.abs(twist[:, 2]).argmax())
    if abs(twist[sharpest, 2]) * least > 1.0 + 1e-6:
        raise InputError(
            f"the path has radius {1.0 / abs(twist[sharpest, 2]):.4g} m {s[sharpest]:.4g} m along it; base "
            f"{base.name!r} turns no sharper than {least:.4g} m"
        )
    if not base.steered:
        return np.zeros((len(s), 0))
    bounded = twist.copy()
    if least > 0.0:
        bounded[:, 2] = np.clip(bounded[:, 2], -1.0 / least, 1.0 / least)
    return np.unwrap(base.steering(bounded), period=math.pi, axis=0)


def _slope(s: Array, values: Array) -> Array:
    """Change of values (n, ...) per way on a piece; places that stand twice in it count once."""
    places, first, where = np.unique(s, return_index=True, return_inverse=True)
    if len(places) < 2:
        return np.zeros_like(values)
    return np.asarray(np.gradient(values[first], places, axis=0)[where])


def _demands(base: WheelBase, drive: DriveLimits, twist: Array, bend: Array, steering: Array, sign: Array) -> Demands:
    """What is asked of motors, floor and wheels at each place, per (a, z)."""
    n, mass = len(sign), drive.mass
    k = twist[:, 2]
    x, y = base.com
    zero = np.zeros(n)
    # acceleration of the centre of mass in base_link and of the heading, per a and per z
    turn = np.stack([k, bend], axis=1)
    ax = np.stack([sign, -(k**2) * x], axis=1) - y * turn
    ay = np.stack([zero, sign * k - k**2 * y], axis=1) + x * turn
    inertia = base.alpha * mass * base.radius**2
    wrench = np.stack([mass * ax, mass * ay, inertia * turn + mass * (x * ay - y * ax)], axis=1)  # (n, 3, 2)
    rows = base.rolling_matrix(steering if base.steered else None)
    rows = np.broadcast_to(rows[..., base._driven_rows, :], (n, len(base.driven), 3))
    held = base.sliding_matrix(steering if base.steered else None)
    free = _free(np.broadcast_to(held, (n, *held.shape[-2:])))
    pushes = np.swapaxes(rows @ free, 1, 2)  # generalised force per rim force (n, p, m)
    force = np.linalg.pinv(pushes, rcond=1e-9) @ (np.swapaxes(free, 1, 2) @ wrench)
    holding = np.array([wheel.name in base.sliding_names for wheel in base.wheels])
    rims = np.einsum("nmi,ni->nm", rows, twist)
    load, driven, holds = _loads(drive, np.stack([ax, ay], axis=1), holding)
    top = drive.rim_speed
    low, high = drive.motor_limits(np.linspace(-top, top, _TABLE))
    strongest = float(max(np.abs(low).max(), np.abs(high).max()))
    most = strongest * float(np.abs(rims).sum(axis=1).max()) / mass
    if math.isfinite(drive.friction):
        most = min(most, drive.friction * GRAVITY)
    return Demands(
        rims, np.ascontiguousarray(force), load, np.ascontiguousarray(wrench[:, 1] * bool(holding.any())),
        np.full(n, math.inf), driven, holds, np.cos(np.asarray(drive.angles, float)), float(drive.friction),
        top, low, high, 1.05 * most,
    )  # fmt: skip


def _free(held: Array) -> Array:
    """Twists (n, 3, p) that no sliding row (n, q, 3) forbids; p is the same at all places."""
    n = len(held)
    if held.shape[1] == 0:
        return np.broadcast_to(np.eye(3), (n, 3, 3))
    _, size, Vt = np.linalg.svd(np.concatenate([held, np.zeros((n, 3, 3))], axis=1))
    rank = int((size > 1e-6).sum(axis=1).max())
    return np.swapaxes(Vt[:, rank:], 1, 2)


def _loads(
    drive: DriveLimits, acceleration: Array, holding: NDArray[np.bool_]
) -> tuple[Array, NDArray[np.int64], NDArray[np.bool_]]:
    """Loads (n, w, 3) per (1, a, z), which of them are driven (m,), which hold the base across (w,)."""
    n = len(acceleration)
    if drive.stance is None:
        loads = np.asarray(drive.loads, float)
        found = np.zeros((n, len(loads), 3))
        found[:, :, 0] = loads
        return found, np.arange(len(loads), dtype=np.int64), np.ones(len(loads), np.bool_)
    at = drive.stance.points
    shares = np.linalg.pinv(np.concatenate([np.ones((1, len(at))), at.T]))
    found = np.zeros((n, len(at), 3))
    found[:, :, 0] = drive.stance.weight * shares[:, 0]
    found[:, :, 1:] = -drive.stance.weight * drive.stance.height / GRAVITY * (shares[:, 1:] @ acceleration)
    return found, np.array(drive.stance.driven, np.int64), holding


def _cap(demands: Demands, max_speed: float, steering_rate: float, turning: Array) -> Array:
    """Largest squared speed (n,): of rims, of the path, and at which the wheels are steered fast enough."""
    with np.errstate(divide="ignore"):
        v = np.minimum(demands.top / np.abs(demands.rim).max(axis=1), max_speed)
        if turning.shape[1] and math.isfinite(steering_rate):
            v = np.minimum(v, steering_rate / np.abs(turning).max(axis=1))
    return np.asarray(v**2)


def _in_time(s: Array, square: Array, jump: NDArray[np.int64], steering: Array, rate: float) -> SpeedProfile:
    v, step = np.sqrt(square), np.diff(s)
    total = v[1:] + v[:-1]
    duration = np.divide(2.0 * step, total, out=np.zeros_like(step), where=step > 0.0)
    if steering.shape[1] and math.isfinite(rate) and len(jump):
        duration[jump] = np.abs(steering[jump + 1] - steering[jump]).max(axis=1) / rate
    a = np.divide(np.diff(square), 2.0 * step, out=np.zeros_like(step), where=step > 0.0)
    return SpeedProfile(s, v, np.append(a, 0.0), np.concatenate([[0.0], np.cumsum(duration)]))
