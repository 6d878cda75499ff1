"""Convex polygons in the plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.errors import InputError

__all__ = ["gap", "hull", "margin", "normals_and_offsets"]

FLAT = 1e-9
"""Second singular value of points, as a share of the first, up to which they lie on a line."""


def hull(points: ArrayLike) -> Array:
    """Corners (k, 2) of the convex hull of points (n, 2), counter-clockwise.

    Raises
    ------
    InputError
        Fewer than three points, or all on one line.
    """
    p = vectors("points", points, 2)
    spread = np.linalg.svd(p - p.mean(axis=0), compute_uv=False)
    if len(p) < 3 or spread[1] <= FLAT * max(spread[0], 1e-300):
        raise InputError(f"{len(p)} points span no area; give three that are not on one line")
    from scipy.spatial import ConvexHull

    corners: Array = p[ConvexHull(p).vertices]
    return corners


def normals_and_offsets(corners: Array) -> tuple[Array, Array]:
    """Outward unit normals (k, 2) of the edges of corners (k, 2), and how far along each its edge lies, (k,)."""
    along = np.roll(corners, -1, axis=0) - corners
    normals = np.stack([along[:, 1], -along[:, 0]], axis=-1) / np.linalg.norm(along, axis=1, keepdims=True)
    return normals, np.einsum("ki,ki->k", normals, corners)


def margin(corners: Array, points: ArrayLike) -> Array:
    """Distance (...) of points (..., 2) from the nearest edge's line; below zero outside the polygon."""
    normals, offsets = normals_and_offsets(corners)
    found: Array = np.asarray((offsets - vectors("points", points, 2) @ normals.T).min(axis=-1))
    return found


def gap(corners: Array, others: Array) -> float:
    """Distance of two convex polygons (k, 2), (m, 2), m; where they overlap less than zero: how far to move one out.

    Corners are counter-clockwise. An edge's line parts what does not overlap (Ericson, Real-Time Collision Detection,
    5.2.1); the nearest points are a corner of one and a point of an edge of the other.
    """
    beyond = max(_beyond(corners, others), _beyond(others, corners))
    if beyond <= 0.0:
        return beyond
    return min(_corner_to_edge(corners, others), _corner_to_edge(others, corners))


def _beyond(corners: Array, others: Array) -> float:
    """How far others lie beyond the edge that they are farthest beyond, m."""
    normals, offsets = normals_and_offsets(corners)
    return float(((normals @ others.T).min(axis=1) - offsets).max())


def _corner_to_edge(corners: Array, points: Array) -> float:
    """Least distance of points from the edges of corners, m."""
    along = np.roll(corners, -1, axis=0) - corners
    away = points[:, None] - corners
    share = np.clip(np.sum(away * along, axis=-1) / np.sum(along * along, axis=-1), 0.0, 1.0)
    return float(np.linalg.norm(away - share[..., None] * along, axis=-1).min())
