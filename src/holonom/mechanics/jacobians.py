"""Beyond the geometric Jacobian: its rate, its derivatives by the joints, and the Jacobian of Euler angle rates."""

from __future__ import annotations

from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.kernels.results import AnalyticJacobian

__all__ = ["AnalyticJacobian", "acceleration_bias", "analytic_jacobian", "jacobian_hessian", "jacobian_rate"]


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
