"""What verbs of several results give back; their kernels make these tuples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = [
    "AnalyticJacobian",
    "CouplingTable",
    "Ellipsoid",
    "Energy",
    "ForwardDynamicsDerivatives",
    "InverseDynamicsDerivatives",
    "Singularity",
]


class AnalyticJacobian(NamedTuple):
    """J (..., 6, n), rows [v; angle rates]; where `degenerate` (...) holds the rates are undefined, their rows zero."""

    J: Array
    degenerate: NDArray[np.bool_]


class InverseDynamicsDerivatives(NamedTuple):
    """Each (..., n, n): entry ij is d tau_i / d q_j, d qd_j, d qdd_j; the last one is the mass matrix."""

    dtau_dq: Array
    dtau_dqd: Array
    dtau_dqdd: Array


class ForwardDynamicsDerivatives(NamedTuple):
    """Each (..., n, n): entry ij is d qdd_i / d q_j, d qd_j, d tau_j; the last one is the inverse mass matrix."""

    dqdd_dq: Array
    dqdd_dqd: Array
    dqdd_dtau: Array


class Energy(NamedTuple):
    """Kinetic and potential energy, (...) J; the potential one is zero with all mass in the world's origin."""

    kinetic: Array
    potential: Array


class CouplingTable(NamedTuple):
    """The table D_i, D_ij, D_ijk of the equations of motion without friction.

    tau_i = gravity_i + sum_j inertia_ij qdd_j + sum_j centrifugal_ij qd_j^2 + sum_jk coriolis_ijk qd_j qd_k

    gravity : (..., n); inertia : (..., n, n); centrifugal : (..., n, n), c_ijj; coriolis : (..., n, n, n), c_ijk for
    j != k (symmetric, both orders counted), zero for j = k.
    """

    gravity: Array
    inertia: Array
    centrifugal: Array
    coriolis: Array


class Ellipsoid(NamedTuple):
    """Principal `axes` (..., 3, 3), one per column, in the world, and `radii` (..., 3), largest first."""

    axes: Array
    radii: Array


class Singularity(NamedTuple):
    """How near an arm is to a singularity.

    `value` is 0 at it (a length in m, the sine of an angle, or a singular value). Of one that is `near`, `direction`
    (6,) is the unit twist [v; w] in the world that is lost there: along it the tool is moved the least. Else None.
    """

    name: str
    value: float
    near: bool
    direction: Array | None
