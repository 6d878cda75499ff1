"""Derivatives of the dynamics, Christoffel symbols, energies and momenta, rotor model and payload.

Inverse and forward dynamics, mass and Coriolis matrix and gravity are methods of `Arm`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.kernels.placement import bodies_of
from holonom.mechanics.kernels.results import (
    CouplingTable,
    Energy,
    ForwardDynamicsDerivatives,
    InverseDynamicsDerivatives,
)
from holonom.model import Body
from holonom.model.arm import Rotors

__all__ = [
    "CouplingTable",
    "Energy",
    "ForwardDynamicsDerivatives",
    "InverseDynamicsDerivatives",
    "bias",
    "centre_of_mass",
    "centroidal_momentum",
    "christoffel",
    "coupling_table",
    "energy",
    "forward_dynamics_derivatives",
    "inverse_dynamics_derivatives",
    "momentum",
    "with_payload",
    "with_rotors",
]


def inverse_dynamics_derivatives(
    arm: Arm,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    *,
    friction: bool | None = None,
    out: tuple[Array, Array, Array] | None = None,
    threads: int = 1,
) -> InverseDynamicsDerivatives:
    """Derivatives of the inverse dynamics with respect to q, qd and qdd (Singh, Russell & Wensing 2022).

    Parameters
    ----------
    q, qd, qdd : (..., n) rad, rad/s, rad/s2 (m, ... for prismatic joints).
    friction : whether joint friction is in, by default where the model has any; its jump at rest has no derivative.
    out : three C-contiguous arrays (..., n, n) to write into.

    Raises
    ------
    ShapeError, MissingInertia
    """
    call = arm.calls["inverse_dynamics_derivatives", friction]
    result: InverseDynamicsDerivatives = call(q, qd, qdd, out=out, threads=threads)
    return result


def forward_dynamics_derivatives(
    arm: Arm,
    q: ArrayLike,
    qd: ArrayLike,
    tau: ArrayLike,
    *,
    friction: bool | None = None,
    out: tuple[Array, Array, Array] | None = None,
    threads: int = 1,
) -> ForwardDynamicsDerivatives:
    """Derivatives of the forward dynamics with respect to q, qd and tau, by d qdd = -B^-1 d(tau_inverse).

    Parameters
    ----------
    q, qd, tau : (..., n) rad, rad/s, N m.
    friction, out : as for `inverse_dynamics_derivatives`.
    """
    call = arm.calls["forward_dynamics_derivatives", friction]
    result: ForwardDynamicsDerivatives = call(q, qd, tau, out=out, threads=threads)
    return result


def christoffel(arm: Arm, q: ArrayLike, *, threads: int = 1) -> Array:
    """Christoffel symbols c_ijk of the mass matrix, (..., n, n, n), symmetric in j and k (specification 2.1).

    (C qd)_i = sum_jk c_ijk qd_j qd_k.
    """
    result: Array = arm.calls["christoffel"](q, threads=threads)
    return result


def coupling_table(arm: Arm, q: ArrayLike) -> CouplingTable:
    """Gravity, inertia, centrifugal and Coriolis coefficients in one configuration or many, (..., n)."""
    result: CouplingTable = arm.calls["coupling_table"](q)
    return result


def bias(arm: Arm, q: ArrayLike, qd: ArrayLike, *, friction: bool | None = None, threads: int = 1) -> Array:
    """Torques without acceleration: C qd + g and friction, (..., n) N m."""
    result: Array = arm.calls["bias", friction](q, qd, threads=threads)
    return result


def energy(arm: Arm, q: ArrayLike, qd: ArrayLike, *, threads: int = 1) -> Energy:
    """Kinetic energy (rotors included as `arm.model.rotors` says) and potential energy of the arm."""
    result: Energy = arm.calls["energy"](q, qd, threads=threads)
    return result


def momentum(arm: Arm, q: ArrayLike, qd: ArrayLike, *, threads: int = 1) -> Array:
    """Generalised momentum B qd, (..., n)."""
    result: Array = arm.calls["momentum"](q, qd, threads=threads)
    return result


def centroidal_momentum(arm: Arm, q: ArrayLike, qd: ArrayLike, *, threads: int = 1) -> Array:
    """Linear momentum and angular momentum about the centre of mass, in the world, rotors locked: (..., 6)."""
    result: Array = arm.calls["centroidal_momentum"](q, qd, threads=threads)
    return result


def centre_of_mass(arm: Arm, q: ArrayLike, *, threads: int = 1) -> Array:
    """Centre of mass of all moving bodies in the world, (..., 3) m."""
    result: Array = arm.calls["centre_of_mass"](q, threads=threads)
    return result


def with_payload(arm: Arm, payload: Body) -> Arm:
    """Return the arm with a body in its tool, stated in the tool frame.

    Raises
    ------
    MissingInertia
        The arm states no inertias of its own.
    """
    bodies_of(arm.model)
    tool = np.array(arm.model.tool)
    R = tool[:3, :3]
    xx, yy, zz, xy, yz, xz = payload.inertia
    turned = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    x, y, z = (R @ payload.com + tool[:3, 3]).tolist()
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = turned.tolist()
    return arm.with_load(Body(payload.mass, (x, y, z), (xx, yy, zz, xy, yz, xz)))


def with_rotors(arm: Arm, rotors: Rotors) -> Arm:
    """Return the arm with another rotor model (specification 2.1).

    "reflected": gear_ratio^2 I_m on the diagonal of B only. "full": also the coupling of each rotor with the link that
    carries it, and gyroscopic moments; every geared motor on a moving link must state its axis.

    Raises
    ------
    ModelError
        When dynamics are first asked for: a motor states no axis; names the joint.
    """
    return arm.remade(rotors=rotors)
