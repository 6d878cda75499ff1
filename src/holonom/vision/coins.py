"""Coins on a dark, uneven ground: seeds from a flattened image, outlines to a part of a pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import ImageError
from holonom.vision.background import Grey, Image, Mask, ground, lit_region
from holonom.vision.opencv import cv2
from holonom.vision.outline import Outlines, polygon_moments, trace_outlines

__all__ = ["Disc", "find_coins"]


SEED_SIDE = 400  # longer side of the image in which seeds are sought, pixels
RATIO = 1.12  # between the radii of seeds
SEED = 0.3  # least brightness of a seed above its surroundings
FALL = 0.15  # least fall of brightness that counts as an edge
EDGE = 0.75  # least part of the outline that is an edge
ROUND = 0.85  # least 4 pi area / perimeter^2
WIDER = 1.1  # width of the ground's opening in the second look, in units of the largest coin of the first
ROUNDS = 2  # of drawing the outline, each around the centre and size of the last


@dataclass(frozen=True, slots=True, eq=False)
class Disc:
    """A round thing in an image.

    `u`, `v` is its centroid in pixels (right and down; the centre of the first pixel is 0, 0), `area` in
    square pixels, `diameter` that of the circle of equal area, `contour` (n, 2) its outline in pixels.
    """

    u: float
    v: float
    area: float
    diameter: float
    contour: Array


def find_coins(image: Grey, *, smallest: float = 0.04, largest: float = 0.22) -> tuple[Disc, ...]:
    """Find round bright things that lie apart on a dark ground, which need not be even.

    Parameters
    ----------
    image
        Grey photograph, (h, w) uint8.
    smallest, largest
        Bounds of the diameters sought, as parts of the longer side of the image.

    Returns
    -------
    Discs, from top to bottom.

    Raises
    ------
    ImageError
        If the image is not a two-dimensional uint8 array.

    Notes
    -----
    The ground is a morphological opening with a disc wider than any coin; what rises above it is scaled by
    Otsu's threshold (1979) and cut off at 1. Seeds are the maxima, over place and size, of the mean in a
    disc less the mean in the ring around it. A second look takes the size of the largest coin into account:
    the narrower the opening, the better the ground follows uneven light.
    """
    if not isinstance(image, np.ndarray) or image.ndim != 2 or image.dtype != np.uint8:
        came = f"{image.dtype} of shape {image.shape}" if isinstance(image, np.ndarray) else type(image).__name__
        raise ImageError(f"the image is {came}; a grey image (h, w) of uint8 is wanted: see load_photograph")
    if not 0.0 < smallest < largest < 0.5:
        raise ImageError(f"sizes from {smallest} to {largest} of the image; 0 < smallest < largest < 0.5 is wanted")
    coins = _find(image, smallest, largest)
    if not coins:
        return ()
    widest = max(coin.diameter for coin in coins) / max(image.shape)
    coins = _find(image, smallest, min(largest, WIDER * widest))
    return tuple(sorted(coins, key=lambda coin: (coin.v, coin.u)))


def _find(image: Grey, smallest: float, largest: float) -> list[Disc]:
    scale = SEED_SIDE / max(image.shape)
    small = _resize(image, scale)
    region = lit_region(small, blur=SEED_SIDE / 400)
    under = ground(small, region, round(1.1 * largest * SEED_SIDE))
    rise = np.clip(small - under, 0.0, 255.0).astype(np.uint8)
    unit = max(float(cv2.threshold(rise[region], 0, 255, cv2.THRESH_OTSU)[0]), 1.0)
    seeds = _seeds(np.minimum(rise / np.float32(unit), np.float32(1.0)), smallest, largest)
    size = (image.shape[1], image.shape[0])
    relief = ((image - cv2.resize(under, size)) / np.float32(unit)).astype(np.float32)
    inside = cv2.resize(region.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    return _drawn(relief, inside, (seeds[:, :2] + 0.5) / scale - 0.5, seeds[:, 2] / scale)


def _drawn(relief: Image, inside: Mask, centres: Array, radii: Array) -> list[Disc]:
    """Discs around the seeds, each outline drawn around the centre and size of the one before."""
    if not len(radii):
        return []
    for _ in range(ROUNDS):
        outlines = trace_outlines(relief, inside, centres, radii)
        area, centres, _ = polygon_moments(outlines.points)
        radii = np.sqrt(area / np.pi)
    return _accept(outlines)


def _resize(image: Grey, scale: float) -> Grey:
    method = cv2.INTER_AREA if scale < 1.0 else cv2.INTER_LINEAR
    size = (max(1, round(image.shape[1] * scale)), max(1, round(image.shape[0] * scale)))
    return cv2.resize(image, size, interpolation=method).astype(np.uint8)


def _seeds(relief: Image, smallest: float, largest: float) -> Array:
    """Circles (k, 3) that lie apart: u, v, radius in pixels."""
    count = 2 + int(np.log(largest / smallest) / np.log(RATIO))
    radii = 0.5 * SEED_SIDE * np.geomspace(smallest, largest, count)
    stack = np.stack([_disc_less_ring(relief, radius) for radius in radii])
    peak = np.stack([cv2.dilate(layer, np.ones((5, 5), np.uint8)) for layer in stack])
    highest = np.pad(stack, ((1, 1), (0, 0), (0, 0)), constant_values=-1.0)
    found = (stack == peak) & (stack > SEED) & (stack >= highest[:-2]) & (stack >= highest[2:])
    layer, v, u = np.nonzero(found)
    seeds = np.stack([u, v, radii[layer]], axis=-1).astype(np.float64)
    return seeds[_best_apart(seeds[:, :2], 0.5 * seeds[:, 2], stack[found].astype(np.float64), np.minimum)]


def _best_apart(centres: Array, reach: Array, merit: Array, shared: np.ufunc) -> list[int]:
    """Indices, the best first, of circles further apart than what `shared` makes of their two reaches."""
    kept: list[int] = []
    for k in np.argsort(-merit, kind="stable"):
        distance = np.hypot(*(centres[kept] - centres[k]).T)
        if (distance > shared(reach[kept], reach[k])).all():
            kept.append(int(k))
    return kept


def _disc_less_ring(relief: Image, radius: float) -> Image:
    """Mean of the disc around each pixel less the mean of the ring around that disc."""
    half = int(np.ceil(1.3 * radius))
    v, u = np.mgrid[-half : half + 1, -half : half + 1]
    distance = np.hypot(u, v) / radius
    disc = (distance <= 0.95).astype(np.float32)
    ring = ((distance > 1.05) & (distance <= 1.3)).astype(np.float32)
    kernel = disc / disc.sum() - ring / ring.sum()
    return cv2.filter2D(relief, cv2.CV_32F, kernel, borderType=cv2.BORDER_REPLICATE).astype(np.float32)


def _accept(outlines: Outlines) -> list[Disc]:
    """Discs that are round and an edge all around; of overlapping ones that with the stronger edge."""
    area, centres, perimeter = polygon_moments(outlines.points)
    edge = (outlines.fall > FALL).mean(axis=1)
    good = np.flatnonzero((edge >= EDGE) & (4.0 * np.pi * area >= ROUND * perimeter**2))
    radii = np.sqrt(area / np.pi)
    best = good[_best_apart(centres[good], radii[good], outlines.fall[good].mean(axis=1), np.maximum)]
    return [_disc(centres[k], float(area[k]), outlines.points[k]) for k in best]


def _disc(centre: Array, area: float, contour: Array) -> Disc:
    return Disc(float(centre[0]), float(centre[1]), area, float(2.0 * np.sqrt(area / np.pi)), contour)
