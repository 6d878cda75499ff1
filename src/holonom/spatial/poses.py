"""Poses as 4x4 arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import NotAPose

__all__ = ["RIGID", "check_pose", "inverse", "pose"]

Array = NDArray[np.float64]
RIGID = 1e-6
"""What an entry of R R^T may differ from the unit matrix's."""


def pose(position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike | None = None) -> Array:
    """Return T_ab (4, 4) from p_ab (3,) in m and R_ab (3, 3)."""
    T = np.eye(4)
    T[:3, 3] = position
    if rotation is not None:
        T[:3, :3] = rotation
    return T


def inverse(T: Array) -> Array:
    """Return T_ba (..., 4, 4) for T_ab: [R^T, -R^T p]."""
    result = np.zeros_like(T)
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    result[..., :3, :3] = Rt
    result[..., :3, 3] = -np.einsum("...ij,...j->...i", Rt, T[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result


def check_pose(T: Any, name: str = "pose") -> Array:
    """Return `T` as a float array (..., 4, 4) if it is a rigid transform to `RIGID`.

    Raises
    ------
    NotAPose
        Wrong shape, NaN, a rotation part that is none, or a last row that is not 0 0 0 1.
    """
    try:
        given = np.asarray(T)
        A = given if given.dtype.kind == "c" else np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as problem:
        raise NotAPose(f"{name} holds something that is not a number: {problem}") from None
    if A.dtype.kind == "c":
        raise NotAPose(f"{name} holds complex numbers; give real ones")
    if A.shape[-2:] != (4, 4):
        raise NotAPose(f"{name} has shape {A.shape}; (..., 4, 4) is needed")
    if not np.isfinite(A).all():
        raise NotAPose(f"{name} holds NaN or infinity")
    error, handed = _orthonormality(A)
    if error <= RIGID and handed <= 0.0:
        raise NotAPose(f"the rotation part of {name} is a mirror (det R = -1); turn one of its axes round")
    if error > RIGID:
        raise NotAPose(
            f"the rotation part of {name} is no rotation (R R^T differs from I by {error:.1e}); "
            "orthonormalise it, for instance with scipy's Rotation.from_matrix"
        )
    if (A[..., 3, :] != [0.0, 0.0, 0.0, 1.0]).any():
        raise NotAPose(f"the last row of {name} is not 0 0 0 1")
    return A


def _orthonormality(A: Array) -> tuple[float, float]:
    """Largest entry of R R^T - I and least determinant: row by row, which is many times faster than small products."""
    a, b, c = (tuple(A[..., i, k] for k in range(3)) for i in range(3))
    products = [_dot(a, a) - 1.0, _dot(b, b) - 1.0, _dot(c, c) - 1.0, _dot(a, b), _dot(b, c), _dot(a, c)]
    n = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return max(float(np.abs(p).max(initial=0.0)) for p in products), float(_dot(n, c).min(initial=1.0))


def _dot(a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
