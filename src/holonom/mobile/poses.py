"""Poses in the plane, SE(2): exact integration on arcs, composition, relative poses, twists in either frame.

A pose is (x, y, theta), m and rad, of base_link in the world; a twist is (vx, vy, w) in base_link. Arrays lead with
batches. Headings are not wrapped, so that turns add up; `wrapped` brings an angle into (-pi, pi].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, vectors
from holonom.errors import ShapeError

__all__ = [
    "compose",
    "exponential",
    "integrated",
    "inverse",
    "logarithm",
    "moved",
    "relative",
    "twist_at",
    "twist_in_robot",
    "twist_in_world",
    "wrapped",
]  # fmt: skip


def exponential(motion: ArrayLike) -> Array:
    """Pose (..., 3) after driving a constant twist for a unit of time: the exact arc (Lynch & Park 3.3.3, planar).

    The chord points half the turn ahead and is sin(h)/h of the path long, h half the turn; exact as the turn vanishes.

    Parameters
    ----------
    motion : (..., 3) twist times time: m, m, rad.
    """
    xi = vectors("motion", motion, 3)
    half = 0.5 * xi[..., 2]
    chord = np.sinc(half / np.pi)
    return np.stack([*_turned(xi[..., 0] * chord, xi[..., 1] * chord, half), xi[..., 2]], axis=-1)


def logarithm(pose: ArrayLike) -> Array:
    """Motion (..., 3) whose `exponential` is the pose: one constant twist times its time; turns in (-pi, pi]."""
    p = vectors("pose", pose, 3)
    turn = wrapped(p[..., 2])
    half = 0.5 * turn
    x, y = _turned(p[..., 0], p[..., 1], -half)
    chord = np.sinc(half / np.pi)
    return np.stack([x / chord, y / chord, turn], axis=-1)


def compose(a: ArrayLike, b: ArrayLike) -> Array:
    """Pose b, given in the frame of pose a, in the frame of a: T_ac = T_ab T_bc."""
    p, q = vectors("a", a, 3), vectors("b", b, 3)
    x, y = _turned(q[..., 0], q[..., 1], p[..., 2])
    return np.stack(np.broadcast_arrays(p[..., 0] + x, p[..., 1] + y, p[..., 2] + q[..., 2]), axis=-1)


def inverse(pose: ArrayLike) -> Array:
    """Pose of the world seen from the robot: T_ba from T_ab."""
    p = vectors("pose", pose, 3)
    x, y = _turned(-p[..., 0], -p[..., 1], -p[..., 2])
    return np.stack([x, y, -p[..., 2]], axis=-1)


def relative(a: ArrayLike, b: ArrayLike) -> Array:
    """Pose b seen from pose a, both given in one frame: T_ab = T_wa^-1 T_wb; the turn is not wrapped."""
    p, q = vectors("a", a, 3), vectors("b", b, 3)
    x, y = _turned(q[..., 0] - p[..., 0], q[..., 1] - p[..., 1], -p[..., 2])
    return np.stack(np.broadcast_arrays(x, y, q[..., 2] - p[..., 2]), axis=-1)


def moved(pose: ArrayLike, twist: ArrayLike, dt: ArrayLike) -> Array:
    """Pose (..., 3) after a constant twist (..., 3) for `dt` seconds (...)."""
    return compose(pose, exponential(_driven(vectors("twist", twist, 3), dt)))


def integrated(start: ArrayLike, twists: ArrayLike, dt: ArrayLike) -> Array:
    """Poses (..., n + 1, 3) along n twists in a row, each held for its time: exact, arc after arc.

    Parameters
    ----------
    start : (..., 3) first pose.
    twists : (..., n, 3).
    dt : one time, or (..., n) times, s.

    Raises
    ------
    ShapeError
    """
    first, xi = vectors("start", start, 3), vectors("twists", twists, 3)
    if xi.ndim < 2:
        raise ShapeError(f"twists has shape {xi.shape}; (..., n, 3) is needed, one row per step")
    steps = exponential(_driven(xi, dt))
    heading = first[..., None, 2] + _summed(steps[..., 2])
    x, y = _turned(steps[..., 0], steps[..., 1], heading[..., :-1])
    return np.stack([first[..., None, 0] + _summed(x), first[..., None, 1] + _summed(y), heading], axis=-1)


def twist_in_robot(twist: ArrayLike, heading: ArrayLike) -> Array:
    """Twist (..., 3) in base_link of one given in the world: xi_r = Rz(theta)^T xi_w (specification 6.1, errata).

    A robot that heads along +y and moves towards +y of the world moves forwards.
    """
    xi, theta = vectors("twist", twist, 3), finite("heading", heading)
    return np.stack(np.broadcast_arrays(*_turned(xi[..., 0], xi[..., 1], -theta), xi[..., 2]), axis=-1)


def twist_in_world(twist: ArrayLike, heading: ArrayLike) -> Array:
    """Twist (..., 3) along the world's axes of one given in base_link: rates of x, y and theta."""
    return twist_in_robot(twist, -finite("heading", heading))


def twist_at(twist: ArrayLike, point: ArrayLike) -> Array:
    """Twist (..., 3) of a point (..., 2), m in base_link, of a body whose origin moves with a twist: `v + w x r`.

    The other way about, the origin's twist by that of the point, with the point at the opposite sign.
    """
    xi, r = vectors("twist", twist, 3), vectors("point", point, 2)
    vx, vy, w = np.moveaxis(xi, -1, 0)
    return np.stack(np.broadcast_arrays(vx - w * r[..., 1], vy + w * r[..., 0], w), axis=-1)


def wrapped(angle: ArrayLike) -> Array:
    """The same angle in (-pi, pi], rad."""
    a = finite("angle", angle)
    inside: Array = np.where((a > -np.pi) & (a <= np.pi), a, -((np.pi - a) % (2.0 * np.pi)) + np.pi)
    return inside


def _driven(twists: Array, dt: ArrayLike) -> Array:
    times = finite("dt", dt)
    try:
        return twists * times[..., None]
    except ValueError:
        raise ShapeError(f"dt has shape {times.shape}; one time, or one per twist of {twists.shape}") from None


def _turned(x: Array, y: Array, angle: Array) -> tuple[Array, Array]:
    s, c = np.sin(angle), np.cos(angle)
    return c * x - s * y, s * x + c * y


def _summed(steps: Array) -> Array:
    """Running sum along the last axis that starts with 0."""
    return np.concatenate([np.zeros((*steps.shape[:-1], 1)), np.cumsum(steps, axis=-1)], axis=-1)
