"""Poses as 4x4 arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import NotAPose

__all__ = ["check_pose", "inverse", "pose"]

Array = NDArray[np.float64]


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
    """Return `T` as a float array (..., 4, 4) if it is a rigid transform to 1e-6.

    Raises
    ------
    NotAPose
        Wrong shape, NaN, a rotation part that is none, or a last row that is not 0 0 0 1.
    """
    try:
        A = np.asarray(T, dtype=np.float64)
    except (TypeError, ValueError) as problem:
        raise NotAPose(f"{name} holds something that is not a number: {problem}") from None
    if A.shape[-2:] != (4, 4):
        raise NotAPose(f"{name} has shape {A.shape}; (..., 4, 4) is needed")
    if not np.isfinite(A).all():
        raise NotAPose(f"{name} holds NaN or infinity")
    R = A[..., :3, :3]
    error = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max(initial=0.0)
    if error > 1e-6 or (np.linalg.det(R) < 0.0).any():
        raise NotAPose(
            f"the rotation part of {name} is no rotation (R R^T differs from I by {error:.1e}); "
            "orthonormalise it, for instance with scipy's Rotation.from_matrix"
        )
    if np.abs(A[..., 3, :] - [0.0, 0.0, 0.0, 1.0]).max(initial=0.0) > 1e-9:
        raise NotAPose(f"the last row of {name} is not 0 0 0 1")
    return A
