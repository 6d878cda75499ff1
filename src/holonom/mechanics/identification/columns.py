"""The regressor verb, and names and values of its columns: which parameters an arm has."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.equations.dynamics import regressor as equations
from holonom.mechanics.equations.dynamics.regressor import BODY_PARAMETERS, DRIVE_PARAMETERS
from holonom.mechanics.equations.dynamics.rotors import reflected_inertia
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import ArmModel, Friction
from holonom.trace.line.arrays import on_arrays

__all__ = ["column_names", "parameters", "regressor", "regressor_of_rows", "stated_columns"]


def regressor(
    arm: Arm, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: Array | None = None, threads: int = 1
) -> Array:
    """Y(q, qd, qdd) with tau = Y pi: the torque as a linear function of masses, moments, rotors and friction.

    Parameters
    ----------
    q, qd, qdd : (..., n) rad, rad/s, rad/s2.

    Returns
    -------
    Y : (..., n, 14 N) for an arm of N joints (mimics counted). `column_names` names the columns: ten per body (mass,
        first moment, inertia about the link frame's origin, in the link frame), then rotor inertias, viscous
        frictions, positive and negative Coulomb torques of all joints. `parameters` gives a model's pi.

    Raises
    ------
    ShapeError

    Source: Siciliano et al., Robotics, eq. 7.81; Atkeson, An, Hollerbach 1986.
    """
    result: Array = arm.calls["regressor"](q, qd, qdd, out=out, threads=threads)
    return result


def column_names(model: ArmModel) -> tuple[str, ...]:
    """Names of the regressor's columns: "m1", "hx1", ..., "Izz6", "Ia1", ..., "Fv1", ..., "Fs+1", ..., "Fs-6"."""
    joints = range(1, len(model.joints) + 1)
    bodies = [f"{name}{i}" for i in joints for name in BODY_PARAMETERS]
    return (*bodies, *(f"{name}{i}" for name in DRIVE_PARAMETERS for i in joints))


def parameters(model: ArmModel) -> Array:
    """What a model states as the vector pi (14 N,), SI units: zero where nothing is, and without Stribeck's rise."""
    joints = model.joints
    bodies = [0.0] * (10 * len(joints))
    if model.bodies is not None:
        bodies = [float(v) for body in bodies_of(model) for v in equations.to_parameters(body)]
    none = Friction(0.0, 0.0, 0.0)
    stated = [joint.friction or none for joint in joints]
    viscous = [f.viscous for f in stated]
    coulomb = [*(f.coulomb_positive for f in stated), *(f.coulomb_negative for f in stated)]
    return np.array([*bodies, *reflected_inertia(model), *viscous, *coulomb])


def stated_columns(model: ArmModel, *, friction: bool = True) -> NDArray[np.bool_]:
    """Which columns a real arm of this kind has: rotors only where a motor is stated, friction only if asked for."""
    count = len(model.joints)
    motors = [joint.motor is not None for joint in model.joints]
    return np.array([True] * (10 * count) + motors + [friction] * (3 * count))


def regressor_of_rows(model: ArmModel) -> Callable[[Array, Array, Array], Array]:
    """Y as a function of rows q, qd, qdd (N, n) with result (N, n, 14 joints), without compiling anything."""
    n = len(model.independent)
    flat = on_arrays(functools.partial(equations.regressor, model), {"q": n, "qd": n, "qdd": n})
    return lambda q, qd, qdd: flat(q, qd, qdd).reshape(len(q), n, -1)
