"""Motion of a base under the forces of its driven wheels: centre of mass anywhere, sliding constraints kept.

In v = (vx, vy, R w) of base_link, with D the rim speeds per v, C the sliding rows, c the centre of mass and
I = alpha M R^2 the inertia about it, d'Alembert's principle reads `M B a + b = D^T f + C^T lambda`, `C v' = 0`
(Siciliano et al., Robotics: Modelling, Planning and Control, 11.4): forces that hold a wheel sideways do no work.
With S an orthonormal basis of what C leaves free, `a = S (S^T B S)^-1 S^T (D^T f - b) / M + ...`.
"""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.mobile.base.mobility import free_twists

__all__ = ["distinct_rows", "drift", "free_motions", "inertia_over_mass", "reaction"]


def inertia_over_mass(radius: float, alpha: float, com: Array) -> Array:
    """B (3, 3): momentum and angular momentum about the origin over R, per mass and per (vx, vy, R w)."""
    x, y = com / radius
    return np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [-y, x, alpha + x * x + y * y]])


def free_motions(sliding: Array) -> Array:
    """S (3, k): orthonormal motions (vx, vy, R w) that sliding rows (n, 3) leave free."""
    return np.eye(3) if not len(sliding) else free_twists(1.0, sliding)


def reaction(motions: Array, inertia: Array) -> Array:
    """(3, 3) acceleration (ax, ay, R wd) of base_link times the mass, per force (Fx, Fy, torque / R) on it."""
    if motions.shape[1] == 3:
        return np.asarray(np.linalg.inv(inertia), dtype=np.float64)
    reduced = motions.T @ inertia @ motions
    return np.asarray(motions @ np.linalg.solve(reduced, motions.T), dtype=np.float64)


def drift(motions: Array, inertia: Array, com: Array, twist: Array) -> Array:
    """Acceleration (..., 3) (ax, ay, R wd) of base_link that needs no force, at a twist (vx, vy, w).

    Where every motion is free that of a body which turns about its centre of mass; sliding rows turn with the base and
    bend its way.
    """
    vx, vy, w = np.moveaxis(twist, -1, 0)
    zero = np.zeros_like(w)
    turning = np.stack([-w * vy, w * vx, zero], axis=-1)  # the axes turn under the velocity
    pull = np.stack([-w * w * com[0], -w * w * com[1], zero], axis=-1)  # of the centre of mass about the origin
    found: Array = turning - (turning @ inertia.T + pull) @ reaction(motions, inertia).T
    return found


def distinct_rows(rows: Array) -> Array:
    """Rows (n, 3) of which no other one is the same, or points the other way."""
    first = np.take_along_axis(rows, (np.abs(rows) > 1e-12).argmax(axis=1)[:, None], axis=1)
    _, distinct = np.unique(np.round(rows * np.sign(first), 12), axis=0, return_index=True)
    return np.asarray(rows[distinct])
