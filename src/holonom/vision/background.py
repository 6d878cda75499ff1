"""What of an image is photograph, and how far each pixel stands out from the dark ground under it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.vision.opencv import cv2

__all__ = ["ground", "lit_region"]

Grey = NDArray[np.uint8]
Mask = NDArray[np.bool_]
Image = NDArray[np.float32]


def lit_region(image: Grey, *, blur: float, darkest: float = 0.05) -> Mask:
    """Convex hull of all that is not as dark as the darkest of the image, less its blurred rim.

    A photograph is convex. Turned or tilted it leaves black corners, and a print has dark edges;
    next to those the ground of the table looks bright, so they must not take part.

    Parameters
    ----------
    image
        Grey levels, (h, w).
    blur
        Width of the smoothing before the comparison, pixels.
    darkest
        Part of the range of grey levels, from below, that counts as dark.

    Returns
    -------
    (h, w) mask.
    """
    smooth = cv2.GaussianBlur(image, (0, 0), blur)
    low = float(smooth.min())
    bound = low + darkest * (float(np.percentile(smooth, 99)) - low)
    speck = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
    lit = cv2.morphologyEx((smooth > bound).astype(np.uint8), cv2.MORPH_OPEN, speck)
    region = np.zeros(image.shape, np.uint8)
    points = cv2.findNonZero(lit)
    if points is not None:
        cv2.fillConvexPoly(region, cv2.convexHull(points), 1)
    rim = 2 * int(np.ceil(2.0 * blur)) + 1
    return cv2.erode(region, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (rim, rim))) > 0


def ground(image: Grey, region: Mask, width: int) -> Image:
    """Grey level of the ground below what is brighter and narrower than `width` pixels.

    A morphological opening within `region` (Serra 1982), smoothed over a tenth of `width`; the
    image itself outside of the region.
    """
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width | 1, width | 1))
    eroded = cv2.erode(np.where(region, image, 255).astype(np.uint8), disc)
    opened = cv2.dilate(np.where(region, eroded, 0).astype(np.uint8), disc)
    weight = cv2.GaussianBlur(region.astype(np.float32), (0, 0), width / 10)
    total = cv2.GaussianBlur(np.where(region, opened, 0).astype(np.float32), (0, 0), width / 10)
    return np.where(region, total / np.maximum(weight, 1e-6), image).astype(np.float32)
