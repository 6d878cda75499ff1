"""Distances from shapes (Ericson, Real-Time Collision Detection, 5.1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.geometry.shapes import Box, Shape

__all__ = ["distance"]


def distance(shape: Shape, points: ArrayLike) -> Array:
    """Distance (...) of points (..., 3), in the shape's own frame, from its surface, m; below zero inside.

    Raises
    ------
    ShapeError
    """
    p = vectors("points", points, 3)
    if isinstance(shape, Box):
        beyond = np.abs(p) - 0.5 * np.array(shape.size)
    else:
        beyond = np.stack(
            [np.hypot(p[..., 0], p[..., 1]) - shape.radius, np.abs(p[..., 2]) - 0.5 * shape.height], axis=-1
        )
    outside: Array = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
    return outside + np.minimum(beyond.max(axis=-1), 0.0)
