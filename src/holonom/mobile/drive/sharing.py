"""Force of a base shared among its wheels by what each carries: the forces that its controller asks for."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import base_mass, rest_loads
from holonom.mobile.drive.coupling import coupling_of

__all__ = ["shared_forces"]

LEAST_LOAD = 1e-3  # part of the mean load that a wheel counts for at least


def shared_forces(base: WheelBase, acceleration: ArrayLike, *, twist: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Rim forces (..., m), N, for an acceleration (..., 3) (ax, ay, wd) of base_link at a twist (..., 3).

    Those with the least loss by creep, the sum of f^2 / N: `f = M W A^T (A W A^T)^+ a` with A = C_alpha and W the loads
    at rest.

    Raises
    ------
    ShapeError
    ModelError
        A base without mass, or one that tips at rest.
    """
    coupling, loads = coupling_of(base), rest_loads(base)
    weight = np.sqrt(np.maximum(loads / loads.mean(), LEAST_LOAD))
    a = vectors("acceleration", acceleration, 3) * [1.0, 1.0, coupling.radius] - coupling.drift(twist)
    shared: Array = base_mass(base) * a @ (weight[:, None] * np.linalg.pinv(coupling.force * weight, rcond=1e-10)).T
    return shared
