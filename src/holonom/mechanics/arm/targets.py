"""What an inverse is asked for: poses or places, and what is wrong with those that nothing reaches."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, real_array
from holonom.errors import NotAPose
from holonom.mechanics.kernels.inverse.geometry import UNREACHABLE
from holonom.spatial import check_pose

__all__ = ["check_lost", "points"]

CHUNK = 4096
"""Rows that are looked at together, so that a batch takes no more memory than its result."""


def points(T: ArrayLike) -> Array:
    """Points (..., 3), or the places of poses."""
    target = real_array("T", T)
    return target if target.shape[-1:] == (3,) else check_pose(target, "T")[..., :3, 3]


def check_lost(T: ArrayLike, status: NDArray[np.int8]) -> None:
    """Refuse what is no pose: the kernel reaches none of it, so only targets without a reached branch are looked at."""
    k = status.shape[-1]
    poses, rows = np.asarray(T, dtype=float).reshape(-1, 4, 4), status.reshape(-1, k)
    for first in range(0, len(rows), CHUNK):
        lost = (rows[first : first + CHUNK] == UNREACHABLE).all(-1)
        if lost.any():
            try:
                check_pose(poses[first : first + CHUNK][lost])
            except NotAPose:
                check_pose(T, "T")  # names the first that is none
