"""Photographs from files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import cv2
import numpy as np

from holonom.errors import ImageError
from holonom.vision.background import Grey

__all__ = ["load_photograph"]

SMALLEST = 32  # pixels of the shorter side


def load_photograph(path: str | PathLike[str]) -> Grey:
    """Grey levels (h, w) uint8 of an image file of any format that OpenCV reads.

    Raises
    ------
    ImageError
        If the file is missing, cannot be read, is no image, or has a side under 32 pixels.
    """
    file = Path(path)
    try:
        data = np.frombuffer(file.read_bytes(), dtype=np.uint8)
    except OSError as error:
        raise ImageError(f"photograph {file}: {error.strerror or error}; give a readable image file") from error
    image = _decoded(data)
    if image is None:
        raise ImageError(f"photograph {file} is not an image; give a PNG, JPEG or TIFF file")
    if min(image.shape) < SMALLEST:
        height, width = image.shape
        raise ImageError(f"photograph {file} has {width} x {height} pixels; {SMALLEST} x {SMALLEST} is the least")
    return image


def _decoded(data: Grey) -> Grey | None:
    if not data.size:
        return None
    try:
        image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    except cv2.error:
        return None
    return None if image is None else image.astype(np.uint8)
