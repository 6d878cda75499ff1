"""Whether forces determine accelerations: whether every joint of an arm moves some mass on its own."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.errors import MissingInertia
from holonom.mechanics.equations.dynamics.composite_body import floating_mass_matrix, mass_matrix
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import ArmModel

__all__ = ["BY_INERTIA", "check_movable"]

BY_INERTIA = ("forward_dynamics", "forward_dynamics_derivatives", "closed_loop", "stiction")
"""Kernels that divide by the inertia."""

SINGULAR = 1e-13
"""Smallest eigenvalue of B over its diagonal, that counts as none."""
SAMPLES = 3
"""Positions that are looked at: at single ones any arm may be singular, such as one of point masses stretched out."""


def check_movable(model: ArmModel, base: Inertial | None = None) -> None:
    """Refuse an arm some of whose joints move no mass on their own; with a `base` body one that floats.

    Raises
    ------
    MissingInertia
        The model states no masses at all, or not enough; names the joints.
    """
    bodies, rng = bodies_of(model), np.random.default_rng(0)
    best, idle = -1.0, np.zeros(0)
    for _ in range(SAMPLES):
        q = rng.uniform(-1.0, 1.0, len(model.independent)).tolist()
        B = mass_matrix(model, bodies, q) if base is None else floating_mass_matrix(model, bodies, base, q)
        least, direction = _least(np.array(B, dtype=float))
        if least > SINGULAR:
            return
        if least > best:
            best, idle = least, direction
    ways = [f"joint {model.joints[i].name!r}" for i in model.independent]
    if base is not None:
        ways = ["the base"] * 6 + ways
    named = list(dict.fromkeys(way for way, share in zip(ways, idle, strict=True) if abs(share) > 0.1))
    verb = "moves no mass, so its acceleration"
    if len(named) > 1:
        verb = "move no mass of their own, so their accelerations"
    raise MissingInertia(
        f"arm {model.name!r}: {' and '.join(named)} {verb} cannot be found from torques; state the inertia of what is "
        "moved (<inertial> in a URDF), a rotor inertia of its motor, or fix it"
    )


def _least(B: Array) -> tuple[float, Array]:
    """Smallest eigenvalue of B, its diagonal scaled to 1, and its direction; 0 where the diagonal has a zero."""
    diagonal = np.diagonal(B)
    idle = ~(diagonal > 0.0)
    if idle.any():
        return 0.0, idle.astype(float)
    size = np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(B / np.outer(size, size))
    return float(values[0]), vectors[:, 0]
