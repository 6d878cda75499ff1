"""Instantaneous centre of rotation, from a twist and from the axles (Siegwart & Nourbakhsh 3.3.1)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite, vectors
from holonom.errors import InputError, ShapeError
from holonom.mobile.base.protocol import ConstrainedBase

__all__ = ["Centre", "axle_miss", "centre_of_axles", "centre_of_rotation", "centre_of_twist", "twist_about"]

FAR = 1e-9
"""Turn per path over the base's size below which a motion counts as straight."""


class Centre(NamedTuple):
    """A centre of rotation in the plane of the floor, as a point of the projective plane.

    `point` (..., 2) m in base_link, infinite where the motion is straight; `direction` (..., 2) unit vector from the
    origin towards it, or the direction at infinity (to the left of a straight motion); `at_infinity` (...) whether it
    lies there; `miss` (...) the largest distance by which an axle passes it (m; at infinity: of its direction, rad).
    """

    point: Array
    direction: Array
    at_infinity: NDArray[np.bool_]
    miss: Array


def centre_of_twist(twist: ArrayLike) -> Centre:
    """Centre of rotation of a twist: (-vy, vx) / w.

    Parameters
    ----------
    twist : (..., 3), m/s and rad/s in base_link. A base at rest has no centre: its point is infinite, direction (0, 0).

    Raises
    ------
    ShapeError
    """
    xi = vectors("twist", twist, 3)
    toward = np.stack([-xi[..., 1], xi[..., 0]], axis=-1)
    far = np.abs(xi[..., 2]) <= FAR * np.linalg.norm(toward, axis=-1)
    w = np.where(far, 1.0, xi[..., 2])[..., None]
    point = np.where(far[..., None], np.inf, toward / w)
    return Centre(point, _unit(np.where(far[..., None], toward, toward / w)), far, np.zeros(far.shape))


def centre_of_rotation(twist: ArrayLike) -> Array:
    """Centre of rotation (..., 2), m in base_link, of a twist (..., 3): its point alone; infinite of a straight motion.

    Raises
    ------
    ShapeError

    Notes
    -----
    `centre_of_twist` says beside it in which direction a centre at infinity lies.
    """
    return centre_of_twist(twist).point


def twist_about(centre: ArrayLike, rate: ArrayLike) -> Array:
    """Twist (..., 3) of base_link that turns about a centre (..., 2), m in base_link, at a rate (...), rad/s.

    `(w y, -w x, w)`: the centre itself stands still. `centre_of_rotation` is the other way about. A straight motion has
    no centre and is given as a twist.

    Raises
    ------
    ShapeError
        A centre that is not two finite numbers, rates that do not fit the centres.
    """
    x, y = np.moveaxis(vectors("centre", centre, 2), -1, 0)
    w = finite("rate", rate)
    try:
        return np.stack(np.broadcast_arrays(w * y, -w * x, w), axis=-1)
    except ValueError:
        raise ShapeError(f"rate has shape {w.shape}, centre {(*x.shape, 2)}; one rate, or one per centre") from None


def centre_of_axles(base: ConstrainedBase, steering: ArrayLike | None = None) -> Centre:
    """Where the axles of the fixed and steered wheels meet: least squares over their distances to the point.

    The centre is the twist that drags the wheels least (smallest sum of squared sideways speeds among unit twists in
    (vx, vy, R w)); of axles that all lie on one line it is the point nearest to the origin, of parallel ones it lies
    at infinity. `miss` says by how much the axles do not meet.

    Parameters
    ----------
    steering : (..., k) rad; None: at rest.

    Raises
    ------
    InputError
        The base has neither fixed nor steered wheels: any point may be the centre.
    ShapeError
    """
    C1 = base.sliding_matrix(steering)
    if C1.shape[-2] == 0:
        raise InputError(f"base {base.name!r} has no axle that constrains it; any point may be its centre of rotation")
    scale = np.array([1.0, 1.0, 1.0 / base.radius])
    eta = np.array([_least_dragging(rows) for rows in (C1 * scale).reshape(-1, *C1.shape[-2:])])
    found = centre_of_twist((eta * scale).reshape(*C1.shape[:-2], 3))
    return found._replace(miss=_misses(C1, found))


def axle_miss(radius: float, C1: Array) -> float:
    """Largest distance (m) by which axles, given by sliding rows (rows, 3), pass the point that fits them best."""
    scale = np.array([1.0, 1.0, 1.0 / radius])
    found = centre_of_twist(_least_dragging(C1 * scale) * scale)
    return float(_misses(C1, found))


def _least_dragging(rows: Array) -> Array:
    """Unit twist that rows (n, 3) see least; among several, the one that turns most about the nearest point."""
    _, s, Vt = np.linalg.svd(np.concatenate([rows, np.zeros((3, 3))]))
    free = Vt[np.count_nonzero(s > 1e-9) :].T if s[-1] <= 1e-9 else Vt[-1:].T
    turn = free[2]
    return free @ (turn / np.linalg.norm(turn)) if np.linalg.norm(turn) > 1e-9 else free[:, 0]


def _misses(C1: Array, centre: Centre) -> Array:
    """Largest distance of an axle from the centre; an axle's row is (n, n x p), so its distance is |row (centre)|."""
    normal, moment = C1[..., :2], C1[..., 2]
    point = np.where(centre.at_infinity[..., None], 0.0, centre.point)
    velocity = np.stack([point[..., 1], -point[..., 0]], axis=-1)  # of the origin, turning at 1 rad/s about the centre
    near = np.abs(np.einsum("...ri,...i->...r", normal, velocity) + moment)
    along = np.stack([centre.direction[..., 1], -centre.direction[..., 0]], axis=-1)
    far = np.abs(np.einsum("...ri,...i->...r", normal, along))
    found: Array = np.where(centre.at_infinity[..., None], far, near).max(axis=-1)
    return found


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0)
