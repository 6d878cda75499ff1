"""Outlines of round bright things: the best closed path in polar coordinates, to a part of a pixel.

Each seed is a circle. The image is sampled along rays from its centre; dynamic programming finds the
closed path of one radius per ray that has the strongest fall of brightness outwards and bends little
(active rays, Denzler and Niemann 1999); a parabola places the steepest fall between the samples.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.vision.kernels import closed_path
from holonom.vision.opencv import cv2

__all__ = ["Outlines", "polygon_moments", "trace_outlines"]

Image = NDArray[np.float32]
Mask = NDArray[np.bool_]

RAYS = 96
ANGLES = np.arange(RAYS) * (2.0 * np.pi / RAYS)
STEP = 0.01  # of the seed's radius
RADII = np.arange(0.5, 1.6, STEP)  # of the seed's radius
BROAD = 10  # samples on either side that tell coin from ground
FINE = 3  # samples on either side that place the edge
REACH = 3  # samples that the path may move from ray to ray
BENDING = 1.0  # price of moving by REACH, in units of a full fall of brightness


class Outlines(NamedTuple):
    """Closed outlines (k, rays, 2) in pixels and the fall of brightness across each, (k, rays)."""

    points: Array
    fall: Image


def trace_outlines(relief: Image, region: Mask, centres: Array, radii: Array) -> Outlines:
    """Outline of one bright thing around each centre.

    Parameters
    ----------
    relief
        Brightness above the ground, (h, w), 0 on the ground and about 1 on a coin.
    region
        Where the image is photograph, (h, w); rays end at its border.
    centres, radii
        Seeds, (k, 2) and (k,), pixels.

    Returns
    -------
    Outlines with points u, v in pixels (centre of the first pixel at 0, 0); `fall` is the difference
    of the mean brightness a tenth of a radius inside and outside.
    """
    rays = _along_rays(relief, region, centres, radii)
    broad, fine = _fall(np.clip(rays, 0.0, 1.0), BROAD), _fall(rays, FINE)
    path = _best_paths(broad + np.clip(fine, 0.0, 1.0))
    index = _steepest(fine, path)
    rho = (RADII[0] + STEP * index) * radii[:, None]
    directions = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)
    points = centres[:, None, :] + rho[..., None] * directions
    return Outlines(points, np.take_along_axis(broad, path[..., None], axis=-1)[..., 0])


def polygon_moments(points: Array) -> tuple[Array, Array, Array]:
    """Area (k,), centroid (k, 2) and perimeter (k,) of closed polygons (k, n, 2), by Green's theorem."""
    after = np.roll(points, -1, axis=1)
    cross = points[..., 0] * after[..., 1] - points[..., 1] * after[..., 0]
    area = 0.5 * cross.sum(axis=1)
    centroid = ((points + after) * cross[..., None]).sum(axis=1) / (6.0 * area[:, None])
    return np.abs(area), centroid, np.linalg.norm(after - points, axis=-1).sum(axis=1)


def _along_rays(relief: Image, region: Mask, centres: Array, radii: Array) -> Image:
    """Samples (k, rays, radii); beyond the region the last sample inside repeats."""
    reach = radii[:, None, None] * RADII
    u = (centres[:, :1, None] + reach * np.cos(ANGLES)[:, None]).astype(np.float32)
    v = (centres[:, 1:, None] + reach * np.sin(ANGLES)[:, None]).astype(np.float32)
    rows, shape = (-1, RADII.size), u.shape
    u, v = u.reshape(rows), v.reshape(rows)
    values = cv2.remap(relief, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    weight = cv2.remap(region.astype(np.float32), u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    inside = weight > 0.999  # of all pixels that the value was interpolated from
    last = np.maximum.accumulate(np.where(inside, np.arange(RADII.size), 0), axis=-1)
    return np.take_along_axis(values, last, axis=-1).reshape(shape)


def _fall(rays: Image, width: int) -> Image:
    """Mean of the `width` samples before each sample less the mean of the `width` samples after it."""
    count = rays.shape[-1]
    padded = np.pad(rays, ((0, 0), (0, 0), (width + 1, width)), mode="edge")
    sums = np.cumsum(padded, axis=-1)
    before = sums[..., width : width + count] - sums[..., :count]
    after = sums[..., 2 * width + 1 :] - sums[..., width + 1 : width + 1 + count]
    return ((before - after) / width).astype(np.float32)


def _best_paths(score: Image) -> NDArray[np.int64]:
    """Radius index of the best closed path of each seed, (k, rays)."""
    count, rays, radii = score.shape
    price = (BENDING * (np.arange(REACH + 1) / REACH) ** 2).astype(np.float32)
    best, came = np.empty((2, radii), np.float32), np.empty((2 * rays, radii), np.int16)
    paths = np.empty((count, rays), np.int64)
    for k in range(count):
        closed_path(score[k], price, best, came, paths[k])
    return paths


def _steepest(fall: Image, path: NDArray[np.int64]) -> Array:
    """Index (not whole) of the steepest fall within FINE samples of the path."""
    window = np.clip(path[..., None] + np.arange(-FINE, FINE + 1), 1, fall.shape[-1] - 2)
    top = np.take_along_axis(fall, window, axis=-1).argmax(axis=-1)
    index = np.take_along_axis(window, top[..., None], axis=-1)
    left, here, right = (np.take_along_axis(fall, index + d, axis=-1)[..., 0] for d in (-1, 0, 1))
    curvature = left - 2.0 * here + right
    peak = curvature < 0.0
    shift = np.where(peak, 0.5 * (left - right) / np.where(peak, curvature, -1.0), 0.0)
    return index[..., 0] + np.clip(shift, -0.5, 0.5)
