"""Where rays meet shapes: slabs for boxes, a quadratic and two caps for cylinders (Ericson 2005, 5.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.geometry.shapes import Box, Shape

__all__ = ["ray_cast"]


def ray_cast(shape: Shape, origins: ArrayLike, directions: ArrayLike) -> Array:
    """How far (...) rays go until they meet a shape, in lengths of their directions; infinite where they miss it.

    Parameters
    ----------
    origins, directions : (..., 3) in the shape's own frame; from inside the shape the way is 0.

    Raises
    ------
    ShapeError
    """
    p, d = np.broadcast_arrays(vectors("origins", origins, 3), vectors("directions", directions, 3))
    if isinstance(shape, Box):
        enter, leave = _slabs(p, d, 0.5 * np.array(shape.size))
    else:
        side = _circle(p[..., :2], d[..., :2], shape.radius)
        caps = _slabs(p[..., 2:], d[..., 2:], np.array([0.5 * shape.height]))
        enter, leave = np.maximum(side[0], caps[0]), np.minimum(side[1], caps[1])
    met = (enter <= leave) & (leave >= 0.0)
    found: Array = np.where(met, np.maximum(enter, 0.0), np.inf)
    return found


def _slabs(p: Array, d: Array, half: Array) -> tuple[Array, Array]:
    """From where to where rays lie between pairs of planes at -half and half."""
    still = d == 0.0
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (-half - p) / d, (half - p) / d
    within = np.abs(p) <= half
    near = np.where(still, np.where(within, -np.inf, np.inf), np.minimum(first, second))
    far = np.where(still, np.where(within, np.inf, -np.inf), np.maximum(first, second))
    return near.max(axis=-1), far.min(axis=-1)


def _circle(p: Array, d: Array, radius: float) -> tuple[Array, Array]:
    """From where to where rays in the plane lie within a circle about the origin."""
    a, b = np.sum(d * d, axis=-1), np.sum(p * d, axis=-1)
    c = np.sum(p * p, axis=-1) - radius * radius
    square = b * b - a * c
    still = a == 0.0
    root, safe = np.sqrt(np.maximum(square, 0.0)), np.where(still, 1.0, a)
    missed = np.where(still, c > 0.0, square < 0.0)
    near = np.where(missed, np.inf, np.where(still, -np.inf, (-b - root) / safe))
    far = np.where(missed, -np.inf, np.where(still, np.inf, (-b + root) / safe))
    return near, far
