"""Differential motion and statics of an arm at a configuration (Siciliano 3.3, 3.8, 3.9; Yoshikawa 1985).

Everything follows from the singular values of the geometric Jacobian in the world frame.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import OutOfLimits, ShapeError
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.equations.vectors import Vector, add, cross, matvec
from holonom.mechanics.kernels.results import Ellipsoid, Singularity
from holonom.mechanics.kernels.singularities import NAMED, measures_of, rows_of
from holonom.numeric import svd
from holonom.trace import Number, compile

__all__ = [
    "Ellipsoid",
    "Singularity",
    "force_ellipsoid",
    "joint_torques",
    "largest_force",
    "lost_directions",
    "manipulability",
    "nullspace",
    "singular_values",
    "singularities",
    "transform_twist",
    "transform_wrench",
    "velocity_ellipsoid",
]

Part = Literal["all", "translation", "rotation"]
LOST = 1e-6
"""Singular value below which a direction counts as lost (m or 1 per rad)."""


def _part(arm: Arm, q: ArrayLike, part: Part) -> Array:
    rows, J = rows_of(part), arm.jacobian(q)
    return J if part == "all" else J[..., rows, :]


def singular_values(arm: Arm, q: ArrayLike, part: Part = "all") -> Array:
    """Singular values of the Jacobian (..., min(m, n)), largest first; metres and radians mixed for "all"."""
    return svd.singular_values(_part(arm, q, part))


def manipulability(arm: Arm, q: ArrayLike, part: Part = "all", *, threads: int = 1) -> Array:
    """Yoshikawa's measure sqrt(det(J J^T)) (...); for arms of fewer joints than rows, of J^T J."""
    result: Array = arm.calls["manipulability", part](q, threads=threads)
    return result


def lost_directions(arm: Arm, q: ArrayLike, *, tolerance: float = LOST) -> Array:
    """Unit twists [v; w] in the world (k, 6) along which the tool cannot move at q (n,)."""
    U, s, _ = svd.svd(_one(arm, q))
    return U[:, np.count_nonzero(s > tolerance) :].T.copy()


def nullspace(arm: Arm, q: ArrayLike, *, tolerance: float = LOST) -> Array:
    """Orthonormal joint rates (n, k) that leave the tool at rest at q (n,)."""
    _, s, Vt = svd.svd(_one(arm, q))
    return Vt[np.count_nonzero(s > tolerance) :].T.copy()


def _one(arm: Arm, q: ArrayLike) -> Array:
    J = arm.jacobian(q)
    if J.ndim != 2:
        raise ShapeError(f"q has shape {np.shape(q)}; one configuration ({arm.n},) is needed here")
    return J


def velocity_ellipsoid(arm: Arm, q: ArrayLike, part: Literal["translation", "rotation"] = "translation") -> Ellipsoid:
    """Tool velocities that joint rates of norm 1 reach: radii in m/s (or rad/s) per rad/s."""
    return _ellipsoid(arm, q, part, False)


def force_ellipsoid(arm: Arm, q: ArrayLike, part: Literal["translation", "rotation"] = "translation") -> Ellipsoid:
    """Forces (or moments) that joint torques of norm 1 balance: the velocity ellipsoid's axes, radii inverted.

    A radius is infinite where a direction is lost: the structure carries the load, not the motors.
    """
    return _ellipsoid(arm, q, part, True)


def _ellipsoid(arm: Arm, q: ArrayLike, part: Part, of_forces: bool) -> Ellipsoid:
    axes, s, _ = svd.svd(_part(arm, q, part))
    radii = np.zeros(axes.shape[:-1])
    radii[..., : s.shape[-1]] = s
    if not of_forces:
        return Ellipsoid(axes, radii)
    inverse = np.full(radii.shape, np.inf)
    np.divide(1.0, radii, out=inverse, where=radii > LOST)
    return Ellipsoid(axes[..., ::-1], inverse[..., ::-1])


def singularities(arm: Arm, q: ArrayLike, *, tolerance: float = 0.02) -> tuple[Singularity, ...]:
    """Named singularities at q (n,), nearest first.

    A Puma-type arm has three (specification 1.4): shoulder (wrist centre at its least distance |d3| from axis 1,
    `a2 c2 + a3 c23 - d4 s23 = 0`, m), elbow (stretched or folded, `a3 s3 + d4 c3 = 0`, m) and wrist (`s5 = 0`).
    An arm of three parallel axes (UR) has the same three: shoulder (the point where axes 5 and 6 meet lies in the
    plane of axes 1 and 2, m), elbow (sine of the angle between upper arm and forearm), wrist (sine of the angle between
    axes 4 and 6). Any other arm has "smallest singular value".
    """
    U, s, _ = svd.svd(_one(arm, q))
    named = arm.prepared[_is_named]
    values = arm.calls["singularity_measures"](q).tolist() if named else [float(s[-1])]
    names, lost = NAMED if named else ("smallest singular value",), U[:, len(s) - 1].copy()
    cases = [(name, value, abs(value) < tolerance) for name, value in zip(names, values, strict=True)]
    found = [Singularity(name, value, near, lost if near else None) for name, value, near in cases]
    return tuple(sorted(found, key=lambda s: abs(s.value)))


def _is_named(arm: Arm) -> bool:
    """Whether its singularities have names."""
    return measures_of(arm.first.model) is not None


def joint_torques(arm: Arm, q: ArrayLike, wrench: ArrayLike, frame: str = "world") -> Array:
    """tau = J^T h (..., n) for the wrench h = [f; m] (..., 6) that the arm exerts on its environment, in `frame`.

    `frame`: "world", "base" or "tool". Gravity is not in: add `arm.gravity(q)`.
    """
    result: Array = arm.calls["joint_torques", frame](q, wrench)
    return result


def transform_wrench(T_ab: ArrayLike, h_b: ArrayLike) -> Array:
    """The same wrench [f; m] stated in frame a, its moment about a's origin: f_a = R f, m_a = R m + p x R f."""
    return np.asarray(_transform("wrench")(T_ab, h_b))


def transform_twist(T_ab: ArrayLike, t_b: ArrayLike) -> Array:
    """The same twist [v; w] stated in frame a, v of the point at a's origin: w_a = R w, v_a = R v + p x R w."""
    return np.asarray(_transform("twist")(T_ab, t_b))


@functools.cache
def _transform(what: Literal["wrench", "twist"]) -> Callable[..., Array]:
    def equation(T: Vector, x: Vector) -> list[Number]:
        R, p = [T[0:3], T[4:7], T[8:11]], [T[3], T[7], T[11]]
        first, second = matvec(R, x[:3]), matvec(R, x[3:])
        if what == "wrench":
            return [*first, *add(second, cross(p, first))]
        return [*add(first, cross(p, second)), *second]

    return compile(equation, {"T": (4, 4), what: 6}, {"moved": 6}, name=f"transform_{what}").call


def largest_force(arm: Arm, q: ArrayLike, direction: ArrayLike) -> float:
    """Largest force (N) on the environment along a world direction (3,) that the joints' torque limits allow at rest.

    |J^T f d + g| <= torque limit, joint by joint; gravity takes its part of each limit.

    Raises
    ------
    OutOfLimits
        Gravity alone exceeds a joint's torque limit.
    """
    d = real_array("direction", direction)
    length = np.linalg.norm(d)
    if d.shape != (3,) or not length > 0.0:
        raise ShapeError(f"direction must be (3,) and not zero; {d} came")
    per_newton = _one(arm, q)[:3].T @ (d / length)
    hold, limits = arm.gravity(q), arm.limits
    room = limits.torque - np.abs(hold)
    if (room < 0.0).any():
        j = int(np.argmin(room))
        raise OutOfLimits(
            f"{limits.names[j]} needs {hold[j]:.1f} N m for gravity alone; its limit is {limits.torque[j]:.1f} N m"
        )
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = np.where(per_newton > 0, limits.torque - hold, limits.torque + hold) / np.abs(per_newton)
    return float(np.min(bound[np.abs(per_newton) > 1e-12], initial=np.inf))
