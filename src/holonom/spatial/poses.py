"""Poses as 4x4 arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array
from holonom.errors import NotAPose

__all__ = ["RIGID", "check_pose", "inverse", "pose"]

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
    except (TypeError, ValueError):
        raise NotAPose(f"{name} holds something that is not a number, or rows that differ in length") from None
    if A.dtype.kind == "c":
        raise NotAPose(f"{name} holds complex numbers; give real ones")
    if A.shape[-2:] != (4, 4):
        raise NotAPose(f"{name} has shape {A.shape}; (..., 4, 4) is needed")
    if not np.isfinite(A).all():
        raise NotAPose(f"{name} holds NaN or infinity{_where(~np.isfinite(A).all((-1, -2)))}")
    error, determinant = _orthonormality(A)
    if error.max(initial=0.0) > RIGID:
        raise NotAPose(
            f"the rotation part of {name} is no rotation (R R^T differs from I by {error.max():.1e})"
            f"{_where(error > RIGID)}; orthonormalise it, for instance with scipy's Rotation.from_matrix"
        )
    if determinant.min(initial=1.0) <= 0.0:
        raise NotAPose(
            f"the rotation part of {name} is a mirror (det R = -1){_where(determinant <= 0.0)}; "
            "turn one of its axes round"
        )
    last = A[..., 3, :] != [0.0, 0.0, 0.0, 1.0]
    if last.any():
        raise NotAPose(f"the last row of {name} is not 0 0 0 1{_where(last.any(-1))}")
    return A


def _where(bad: NDArray[np.bool_]) -> str:
    """Which of several poses is the first bad one."""
    return f" in pose {tuple(int(k) for k in np.argwhere(bad)[0])}" if bad.ndim else ""


def _orthonormality(A: Array) -> tuple[Array, Array]:
    """Largest entry of R R^T - I and determinant, of each: row by row, many times faster than small products."""
    a, b, c = (tuple(A[..., i, k] for k in range(3)) for i in range(3))
    error = np.abs(_dot(a, a) - 1.0)
    for p, q, wanted in ((b, b, 1.0), (c, c, 1.0), (a, b, 0.0), (b, c, 0.0), (a, c, 0.0)):
        error = np.maximum(error, np.abs(_dot(p, q) - wanted))
    n = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    return error, _dot(n, c)


def _dot(a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
