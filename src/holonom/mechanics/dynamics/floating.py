"""Dynamics of an arm whose base moves: carried by a vehicle, or floating freely (Featherstone 2008, ch. 9).

The base's twist [v; w] (..., 6) is that of its own origin, in its own frame; its acceleration is the rate of these six
numbers. The base's pose `base` (..., 4, 4) says where gravity points; by default it is the model's. What the base
itself weighs is `arm.model.base_body`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.mechanics.arm.arm import Arm
from holonom.spatial import check_pose

__all__ = [
    "BaseAcceleration",
    "BaseForces",
    "forward_dynamics",
    "inverse_dynamics",
    "jacobian",
    "mass_matrix",
    "momentum",
    "moved",
]

STILL = (0.0,) * 6


class BaseForces(NamedTuple):
    """What a motion needs: wrench [f; m] (..., 6) on the base, about its origin and in its frame; tau (..., n)."""

    wrench: Array
    tau: Array


class BaseAcceleration(NamedTuple):
    """What forces cause: rate (..., 6) of the base's twist, m/s2 and rad/s2; qdd (..., n)."""

    acceleration: Array
    qdd: Array


def inverse_dynamics(
    arm: Arm,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    base: ArrayLike | None = None,
    twist: ArrayLike = STILL,
    acceleration: ArrayLike = STILL,
    friction: bool | None = None,
    threads: int = 1,
) -> BaseForces:
    """Wrench on the base and joint torques for a motion of both.

    Parameters
    ----------
    q, qd, qdd : (..., n) rad, rad/s, rad/s2.
    base : (..., 4, 4), T_w0.
    twist, acceleration : (..., 6) m/s, rad/s and their rates, in the base's frame.
    friction : whether joint friction is in; by default where the model has any.

    Raises
    ------
    ShapeError, NotAPose, MissingInertia
    """
    lifted = vectors("acceleration", acceleration, 6) + np.insert(_minus_gravity(arm, base), 3, [0.0] * 3, axis=-1)
    found = arm.calls["floating_inverse", friction](q, qd, qdd, twist, lifted, threads=threads)
    return BaseForces(*found)


def forward_dynamics(
    arm: Arm,
    q: ArrayLike,
    qd: ArrayLike,
    tau: ArrayLike,
    *,
    base: ArrayLike | None = None,
    twist: ArrayLike = STILL,
    wrench: ArrayLike = STILL,
    friction: bool | None = None,
    threads: int = 1,
) -> BaseAcceleration:
    """Accelerations of base and joints under joint torques and a wrench on the base (none: free flight)."""
    call = arm.calls["floating_forward", friction]
    return BaseAcceleration(*call(q, qd, tau, twist, wrench, _minus_gravity(arm, base), threads=threads))


def mass_matrix(arm: Arm, q: ArrayLike, *, threads: int = 1) -> Array:
    """Inertia (..., 6 + n, 6 + n) over [twist of the base; qd], rotors reflected on the joints' diagonal."""
    result: Array = arm.calls["floating_mass_matrix"](q, threads=threads)
    return result


def momentum(
    arm: Arm, q: ArrayLike, qd: ArrayLike, *, base: ArrayLike | None = None, twist: ArrayLike = STILL
) -> Array:
    """Momentum [p; L] (..., 6) of everything in the world, L about the world's origin, N s and N m s; rotors locked."""
    T = _base(arm, base)
    rates, speed = vectors("twist", twist, 6), vectors("qd", qd, arm.n)
    B = mass_matrix(arm, q)[..., :6, :]
    lead = np.broadcast_shapes(rates.shape[:-1], speed.shape[:-1], B.shape[:-2])
    whole = np.concatenate([np.broadcast_to(rates, (*lead, 6)), np.broadcast_to(speed, (*lead, arm.n))], axis=-1)
    h = np.einsum("...ij,...j->...i", B, whole)
    p, L = (np.einsum("...ij,...j->...i", T[..., :3, :3], part) for part in (h[..., :3], h[..., 3:]))
    return np.concatenate([p, L + np.cross(T[..., :3, 3], p)], axis=-1)


def jacobian(arm: Arm, q: ArrayLike, *, base: ArrayLike | None = None) -> Array:
    """Jacobian (..., 6, 6 + n) of the tool point over [twist of the base; qd], [v; w] in the world."""
    T = _base(arm, base)
    here = np.array(arm.model.base)
    R = T[..., :3, :3] @ here[:3, :3].T
    J = arm.jacobian(q)
    own = np.concatenate([R @ J[..., :3, :], R @ J[..., 3:, :]], axis=-2)
    way = np.einsum("...ij,...j->...i", R, arm.fk(q)[..., :3, 3] - here[:3, 3])
    turn = T[..., :3, :3]
    lead = np.broadcast_shapes(own.shape[:-2], turn.shape[:-2])
    found = np.zeros((*lead, 6, 6 + arm.n))
    found[..., :3, :3] = found[..., 3:, 3:6] = turn
    found[..., :3, 3:6] = np.cross(np.swapaxes(turn, -1, -2), way[..., None, :]).swapaxes(-1, -2)
    found[..., 6:] = own
    return found


def moved(base: ArrayLike, twist: ArrayLike, dt: float) -> Array:
    """The pose (..., 4, 4) of a base that keeps its twist (..., 6) for a time, s: T exp(twist dt)."""
    from scipy.spatial.transform import Rotation

    T, xi = check_pose(base, "base"), vectors("twist", twist, 6) * dt
    v, w = xi[..., :3], xi[..., 3:]
    angle = np.linalg.norm(w, axis=-1)[..., None]
    safe = np.where(angle < 1e-6, 1.0, angle)
    a = np.where(angle < 1e-6, 0.5 - angle**2 / 24.0, (1.0 - np.cos(angle)) / safe**2)
    b = np.where(angle < 1e-6, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    way = v + a * np.cross(w, v) + b * np.cross(w, np.cross(w, v))
    found = np.zeros((*np.broadcast_shapes(T.shape[:-2], xi.shape[:-1]), 4, 4))
    turned = Rotation.from_rotvec(w.reshape(-1, 3)).as_matrix().reshape(*w.shape[:-1], 3, 3)
    found[..., :3, :3] = T[..., :3, :3] @ turned
    found[..., :3, 3] = np.einsum("...ij,...j->...i", T[..., :3, :3], way) + T[..., :3, 3]
    found[..., 3, 3] = 1.0
    return found


def _base(arm: Arm, base: ArrayLike | None) -> Array:
    return np.array(arm.model.base) if base is None else check_pose(base, "base")


def _minus_gravity(arm: Arm, base: ArrayLike | None) -> Array:
    """Minus the gravity (..., 3), in the base's frame."""
    return np.asarray(-np.einsum("...ji,j->...i", _base(arm, base)[..., :3, :3], np.array(arm.model.gravity)))
