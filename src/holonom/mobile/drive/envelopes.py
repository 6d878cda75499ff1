"""How strong and how fast a drive is in each direction: effective motors, acceleration, speed (specification 06.2).

Forces of n wheels within limits make a zonotope in (Fx, Fy, torque / R). How far a ray gets inside it is exact: the
least of `(h(k) - k . p) / (k . d)` over its facets' normals k, the cross products of pairs of columns of D^T, with
`h(k) = sum_i max(k . a_i f_i)`. No linear program is solved.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite, vectors
from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.coupling import Coupling, Wheels, coupling_of, live_wheels
from holonom.mobile.drive.limits import DriveLimits

__all__ = [
    "Envelope",
    "Limit",
    "acceleration_envelope",
    "critical_force",
    "effective_motors",
    "force_envelope",
    "speed_envelope",
]

Base = WheelBase | Coupling | ArrayLike
_ZERO = 1e-10
_HALVINGS = 48


class Limit(IntEnum):
    """What holds a wheel at the edge of an envelope."""

    NONE = 0
    MOTOR = 1
    FRICTION = 2


@dataclass(frozen=True, slots=True)
class Envelope:
    """The most in each of k directions, ready for a polar plot.

    Attributes
    ----------
    directions
        (k,) rad in base_link, counter-clockwise from x.
    value
        (k,) N, m/s2 or m/s; 0 where `reachable` is False.
    reachable
        (k,) whether the demand beside it (a torque) can be met at all in that direction.
    limits
        (k, n) code of `Limit` of each wheel there; `NONE`: that wheel has something left.
    """

    directions: Array
    value: Array
    reachable: NDArray[np.bool_]
    limits: NDArray[np.int64]


def effective_motors(base: Base, directions: ArrayLike, *, out: Wheels = ()) -> Array:
    """Effective number of motors (k,): the largest force with every |f_i| <= 1, no torque and no cross force.

    Parameters
    ----------
    base
        A base, its coupling, or D (n, 3).
    directions
        (k,) rad in base_link, counter-clockwise from x.
    out
        Driven wheels whose motors are dead, by name or number.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName
    """
    return force_envelope(base, directions, out=out).value


def force_envelope(
    base: Base, directions: ArrayLike, *, limits: ArrayLike = 1.0, lower: ArrayLike | None = None,
    torque: float = 0.0, out: Wheels = (),
) -> Envelope:  # fmt: skip
    """Largest force (N) in each direction without cross force, while the torque is held.

    Parameters
    ----------
    base, directions, out
        As in `effective_motors`.
    limits, lower
        Wheel force, N: at most `limits`, at least `lower` (`-limits` unless given); scalar, (n,) or (k, n).
    torque
        N m demanded meanwhile.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName
    """
    coupling = coupling_of(base)
    phi = _directions(directions)
    high = _limits("limits", limits, len(phi), coupling.wheels)
    low = -high if lower is None else _limits("lower", lower, len(phi), coupling.wheels)
    if (low > high).any():
        raise OutOfLimits("force limits: a lower limit is above the upper one; give lower <= limits for each wheel")
    live = live_wheels(coupling, out)
    low, high = np.where(live, low, 0.0), np.where(live, high, 0.0)
    value, reachable, held = _reach(coupling.velocity.T, low, high, torque / coupling.radius, phi)
    return Envelope(phi, value, reachable, np.where(held, Limit.MOTOR, Limit.NONE).astype(np.int64))


def critical_force(base: Base, directions: ArrayLike, drive: DriveLimits, *, out: Wheels = ()) -> Envelope:
    """Force (N) in each direction at which the first wheels slip: friction `mu N_i` alone, motors as strong as need be.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName
    """
    grip = force_envelope(base, directions, limits=drive.grip(), out=out)
    held = np.where(grip.limits > 0, Limit.FRICTION, Limit.NONE).astype(np.int64)
    return Envelope(grip.directions, grip.value, grip.reachable, held)


def acceleration_envelope(
    base: Base, directions: ArrayLike, drive: DriveLimits, *, twist: ArrayLike = (0.0, 0.0, 0.0),
    angular_acceleration: float = 0.0, out: Wheels = (),
) -> Envelope:  # fmt: skip
    """Largest acceleration (m/s2) in each direction under motor and friction limits, and what holds each wheel.

    Parameters
    ----------
    base, directions, out
        As in `effective_motors`.
    drive
        Motors, friction, mass.
    twist
        (vx, vy, w) now, m/s and rad/s: what it takes from the motors.
    angular_acceleration
        rad/s2 demanded meanwhile.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName

    Notes
    -----
    With a centre of mass above ground, wheel loads move with the acceleration; the edge is found by bisection.
    """
    coupling = coupling_of(base)
    phi, D, R = _directions(directions), coupling.velocity, coupling.radius
    live = live_wheels(coupling, out)
    rims = D @ (vectors("twist", twist, 3) * [1.0, 1.0, R])
    motor_low, motor_high = drive.motor_limits(rims)
    turn = coupling.alpha * drive.mass * R * angular_acceleration

    def edge(acceleration: Array) -> tuple[Array, NDArray[np.bool_], NDArray[np.int64]]:
        along = acceleration[:, None] * np.column_stack([np.cos(phi), np.sin(phi)])
        grip = drive.grip(along)
        low = np.where(live, np.maximum(motor_low, -grip), 0.0)
        high = np.where(live, np.minimum(motor_high, grip), 0.0)
        value, reachable, held = _reach(D.T, np.minimum(low, high), high, turn, phi)
        which = np.where(grip < np.minimum(motor_high, -motor_low), Limit.FRICTION, Limit.MOTOR)
        return value / drive.mass, reachable, np.where(held, which, Limit.NONE).astype(np.int64)

    value, reachable, held = edge(np.zeros(len(phi)))
    if drive.transfer is not None:
        value = _crossing(lambda a: edge(a)[0], value)
        _, reachable, held = edge(value)
    return Envelope(phi, value, reachable, held)


def speed_envelope(
    base: Base, directions: ArrayLike, drive: DriveLimits, *, turning: float = 0.0, out: Wheels = ()
) -> Envelope:
    """Largest speed (m/s) in each direction while the base turns at `turning` (rad/s): no wheel beyond its free speed.

    Dead wheels roll freely and bound nothing.

    Raises
    ------
    ShapeError, OutOfLimits, UnknownName
    """
    coupling = coupling_of(base)
    phi = _directions(directions)
    live = live_wheels(coupling, out)
    top = drive.rim_speed
    along = np.column_stack([np.cos(phi), np.sin(phi)]) @ coupling.velocity[live, :2].T
    offset = coupling.velocity[live, 2] * coupling.radius * turning
    with np.errstate(divide="ignore"):
        room = np.where(np.abs(along) > _ZERO, (top - np.sign(along) * offset) / np.abs(along), np.inf)
    reachable = np.full(len(phi), bool((np.abs(offset) <= top).all()))
    value = np.where(reachable, room.min(axis=1, initial=np.inf), 0.0)
    limits = np.zeros((len(phi), coupling.wheels), np.int64)
    limits[:, live] = np.where((room <= value[:, None] * (1.0 + 1e-9)) & reachable[:, None], Limit.MOTOR, Limit.NONE)
    return Envelope(phi, value, reachable, limits)


def _reach(
    A: Array, low: Array, high: Array, turn: float, phi: Array
) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Length of each ray inside the zonotope of A's columns, whether it meets it, and which columns are at an end."""
    K = _normals(A)
    heights = K @ A
    support = high @ np.maximum(heights, 0.0).T + low @ np.minimum(heights, 0.0).T - K[:, 2] * turn
    slope = np.column_stack([np.cos(phi), np.sin(phi)]) @ K[:, :2].T
    scale = np.abs(heights).max() * np.abs(high - low).max() + abs(turn)
    ahead = slope > _ZERO
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = support / slope
    farthest = np.where(ahead, ratio, np.inf).min(axis=1)
    nearest = np.maximum(np.where(slope < -_ZERO, ratio, -np.inf).max(axis=1), 0.0)
    flat = np.where(np.abs(slope) <= _ZERO, support, 0.0).min(axis=1)
    reachable = (farthest >= nearest - 1e-9 * scale) & (flat >= -1e-9 * scale)
    value = np.where(reachable, np.maximum(farthest, 0.0), 0.0)
    on = ahead & reachable[:, None] & (support - slope * value[:, None] <= 1e-9 * scale)
    held: NDArray[np.bool_] = (on @ (np.abs(heights) > _ZERO).astype(float) > 0.5) & (high > low)
    return value, reachable, held


def _normals(A: Array) -> Array:
    """Unit normals (q, 3), both signs, of all facets that columns (3, n) can span; also where they span no volume."""
    generators = np.column_stack([A, scipy.linalg.null_space(A.T, rcond=_ZERO)]).T
    pairs = np.array(list(itertools.combinations(range(len(generators)), 2)))
    K = np.cross(generators[pairs[:, 0]], generators[pairs[:, 1]])
    size = np.linalg.norm(K, axis=1)
    K = K[size > _ZERO] / size[size > _ZERO, None]
    return np.concatenate([K, -K])


def _crossing(edge: Callable[[Array], Array], first: Array) -> Array:
    """Largest a (k,) with `a <= edge(a)`, from a = 0 on."""
    low, high = np.zeros_like(first), 2.0 * first + 1.0
    while (edge(high) >= high).any():
        high = 2.0 * high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        inside = edge(middle) >= middle
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return low


def _directions(directions: ArrayLike) -> Array:
    phi = np.atleast_1d(finite("directions", directions))
    if phi.ndim != 1:
        raise ShapeError(f"directions have shape {phi.shape}; they must be (k,) angles in rad")
    return phi


def _limits(name: str, values: ArrayLike, k: int, n: int) -> Array:
    array = finite(name, values)
    if array.shape not in ((), (n,), (k, n)):
        raise ShapeError(f"{name} has shape {array.shape}; it must be a number, ({n},) or ({k}, {n}) of them")
    return array if array.ndim == 2 else np.broadcast_to(array, (1, n))
