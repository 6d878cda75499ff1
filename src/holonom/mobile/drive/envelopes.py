"""How strong and how fast a drive is in each direction: effective motors, acceleration, speed (specification 06.2).

Forces of n wheels within limits make a zonotope in M (ax, ay, R wd) = C_alpha f. How far a ray gets inside it is exact:
the least of `(h(k) - k . p) / (k . d)` over its facets' normals k, the cross products of pairs of columns of C_alpha,
with `h(k) = sum_i max(k . a_i f_i)`. No linear program is solved. A direction that drags a wheel sideways is none.
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
_ALONG = 1e-9  # sine of an angle below which two directions are one
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
        N m about the centre of mass demanded meanwhile.

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
    x, y = coupling.com
    aside = torque / (coupling.alpha * coupling.radius**2)  # turning moves base_link beside the centre of mass
    offset = np.array([aside * y, -aside * x, aside * coupling.radius])
    value, reachable, held = _reach(coupling.force, low, high, offset, phi)
    return Envelope(phi, value, reachable, np.where(held, Limit.MOTOR, Limit.NONE).astype(np.int64))


def critical_force(base: Base, directions: ArrayLike, drive: DriveLimits, *, out: Wheels = ()) -> Envelope:
    """Force (N) in each direction at which the first wheels slip: friction alone, motors as strong as need be.

    A wheel pushes with up to `mu N_i` along its rollers' axes, that is `mu N_i cos(gamma_i)` at its rim.

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
    """Largest acceleration (m/s2) of base_link in each direction under motor and friction limits, and what holds it.

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
    With a centre of mass above ground, wheel loads move with the acceleration; the edge is found by bisection. It is
    where the base tips, if that comes first.
    """
    coupling = coupling_of(base)
    phi, R, com = _directions(directions), coupling.radius, np.array(coupling.com)
    live, now = live_wheels(coupling, out), vectors("twist", twist, 3)
    motor_low, motor_high = drive.motor_limits(coupling.velocity @ (now * [1.0, 1.0, R]))
    offset = drive.mass * (np.array([0.0, 0.0, R * angular_acceleration]) - coupling.drift(now))
    beside = angular_acceleration * np.array([-com[1], com[0]]) - now[2] ** 2 * com
    C = coupling.force

    def edge(acceleration: Array) -> tuple[Array, NDArray[np.bool_], NDArray[np.int64]]:
        along = acceleration[:, None] * np.column_stack([np.cos(phi), np.sin(phi)])
        grip = drive.grip(along + beside)
        low = np.where(live, np.maximum(motor_low, -grip), 0.0)
        high = np.where(live, np.minimum(motor_high, grip), 0.0)
        value, reachable, held = _reach(C, np.minimum(low, high), high, offset, phi)
        which = np.where(grip < np.minimum(motor_high, -motor_low), Limit.FRICTION, Limit.MOTOR)
        return value / drive.mass, reachable, np.where(held, which, Limit.NONE).astype(np.int64)

    value, reachable, held = edge(np.zeros(len(phi)))
    if drive.stance is not None and drive.stance.height > 0.0:
        value = _crossing(lambda a: edge(a)[0], value)
        _, reachable, held = edge(value)
    return Envelope(phi, value, reachable, held)


def speed_envelope(
    base: Base, directions: ArrayLike, drive: DriveLimits, *, turning: float = 0.0, out: Wheels = ()
) -> Envelope:
    """Largest speed (m/s) in each direction while the base turns at `turning` (rad/s): no wheel beyond its free speed.

    Dead wheels roll freely and bound nothing; where the others cannot push the base without turning it, and where a
    wheel would be dragged sideways, no speed is reachable.

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
    ahead = np.column_stack([np.cos(phi), np.sin(phi), np.zeros(len(phi))])
    still = np.abs(coupling.sliding[:, 2] * coupling.radius * turning).max(initial=0.0) <= _ALONG
    pushed = _within(coupling.force[:, live], ahead) & still
    reachable = pushed & bool((np.abs(offset) <= top).all())
    value = np.where(reachable, room.min(axis=1, initial=np.inf), 0.0)
    limits = np.zeros((len(phi), coupling.wheels), np.int64)
    limits[:, live] = np.where((room <= value[:, None] * (1.0 + 1e-9)) & reachable[:, None], Limit.MOTOR, Limit.NONE)
    return Envelope(phi, value, reachable, limits)


def _within(A: Array, vectors_: Array) -> NDArray[np.bool_]:
    """Whether vectors (k, 3) lie in the span of A's columns (3, n)."""
    across = scipy.linalg.null_space(A.T, rcond=_ALONG) if A.shape[1] else np.eye(3)
    inside: NDArray[np.bool_] = np.abs(vectors_ @ across).max(axis=1, initial=0.0) <= _ALONG
    return inside


def _reach(
    A: Array, low: Array, high: Array, offset: Array, phi: Array
) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """Length of each ray from an offset (3,) inside the zonotope of A's columns, whether it meets it, columns at ends.

    Rays start anywhere on the line through the offset: it need not lie inside.
    """
    K = _normals(A)
    heights = K @ A
    support = high @ np.maximum(heights, 0.0).T + low @ np.minimum(heights, 0.0).T - K @ offset
    slope = np.column_stack([np.cos(phi), np.sin(phi)]) @ K[:, :2].T
    scale = np.abs(heights).max() * np.abs(high - low).max() + np.abs(offset).max()
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
