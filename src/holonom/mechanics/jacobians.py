"""Beyond the geometric Jacobian: its rate, its derivatives by the joints, and the Jacobian of Euler angle rates."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.kernels.jacobian import frame_named
from holonom.mechanics.kernels.results import AnalyticJacobian

__all__ = [
    "AnalyticJacobian",
    "acceleration_bias",
    "analytic_jacobian",
    "jacobian_hessian",
    "jacobian_rate",
    "point_jacobian",
]


def point_jacobian(
    arm: Arm, q: ArrayLike, point: ArrayLike, *, of: str = "tool", frame: str = "world", threads: int = 1
) -> Array:
    """Geometric Jacobian of a point that is fixed to a frame: its velocity is v + w x r (Siciliano 3.1).

    Parameters
    ----------
    q : (..., n).
    point : (..., 3) m, in the frame `of`, a name as for `Arm.fk`.
    frame : in which v and w are expressed, as for `Arm.jacobian`.

    Returns
    -------
    J : (..., 6, n).

    Raises
    ------
    ShapeError, NotFinite, UnknownName
    """
    p = vectors("point", point, 3)
    J = arm.jacobian(q, "own", of=of, threads=threads)
    if p.ndim > 1 and p.shape[:-1] != J.shape[:-2]:
        lead = np.broadcast_shapes(p.shape[:-1], J.shape[:-2])
        p, J = np.broadcast_to(p, (*lead, 3)), np.broadcast_to(J, (*lead, *J.shape[-2:]))
    v = J[..., :3, :] + np.cross(J[..., 3:, :], p[..., :, None], axis=-2)
    if frame == "own":
        return np.concatenate([v, J[..., 3:, :]], axis=-2)
    R = arm.fk(q, of)[..., :3, :3]
    if frame != "world":
        R = np.swapaxes(arm.fk(q, frame_named({"frame": frame}))[..., :3, :3], -1, -2) @ R
    return np.concatenate([R @ v, R @ J[..., 3:, :]], axis=-2)


def jacobian_rate(arm: Arm, q: ArrayLike, qd: ArrayLike, frame: str = "world", *, threads: int = 1) -> Array:
    """Rate of the geometric Jacobian along a motion, (..., 6, n); `frame` as in `Arm.jacobian`.

    In the tool frame it is the rate of the components, seen by an observer who moves with the tool.
    """
    result: Array = arm.calls["jacobian_rate", frame](q, qd, threads=threads)
    return result


def acceleration_bias(arm: Arm, q: ArrayLike, qd: ArrayLike, frame: str = "world", *, threads: int = 1) -> Array:
    """Jdot qd, (..., 6): what the tool's acceleration [vd; wd] = J qdd + Jdot qd is without joint accelerations."""
    result: Array = arm.calls["acceleration_bias", frame](q, qd, threads=threads)
    return result


def jacobian_hessian(arm: Arm, q: ArrayLike, frame: str = "world", *, threads: int = 1) -> Array:
    """Derivatives of the geometric Jacobian: H[..., i, j, k] = d J_ij / d q_k, (..., 6, n, n)."""
    result: Array = arm.calls["jacobian_hessian", frame](q, threads=threads)
    return result


def analytic_jacobian(arm: Arm, q: ArrayLike, *, angles: str, threads: int = 1) -> AnalyticJacobian:
    """Jacobian of the tool's position and Euler angles in the world (Siciliano 3.6).

    Parameters
    ----------
    q : (..., n).
    angles : "zyz" (phi, theta, psi) or "rpy" (roll, pitch, yaw), those of `spatial.zyz_angles` and `spatial.rpy_angles`
        in the first branch.

    Returns
    -------
    The Jacobian, and whether the angles are degenerate: sin(theta) = 0 for ZYZ, cos(pitch) = 0 for RPY. Only a sum or
    difference of two angles is defined there.
    """
    result: AnalyticJacobian = arm.calls["analytic_jacobian", angles](q, threads=threads)
    return result
