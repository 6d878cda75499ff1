"""Photographs from files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from holonom.errors import ImageError
from holonom.files import read_bytes
from holonom.vision.background import Grey
from holonom.vision.image_size import stated_size
from holonom.vision.opencv import cv2

__all__ = ["load_photograph"]

SMALLEST, LARGEST = 32, 16_384
"""Pixels of the shorter side at least, of the longer one at most."""
PIXELS = 40_000_000
"""Pixels altogether."""


def load_photograph(path: str | PathLike[str]) -> Grey:
    """Grey levels (h, w) uint8 of a PNG, JPEG, TIFF or BMP file.

    Raises
    ------
    ImageError
        If the file is missing, cannot be read, is no such image, has a side under 32 or over 16384 pixels, or more than
        40 megapixels: what it states is looked at before it is unpacked.
    MissingExtra
        OpenCV is not installed.
    """
    file = Path(path)
    data = read_bytes(file, "photograph", ImageError)
    size = stated_size(data)
    if size is not None:
        _check_size(file, *size)
    image = None if size is None else _decoded(np.frombuffer(data, dtype=np.uint8))
    if image is None:
        raise ImageError(f"photograph {file} is not an image; give a PNG, JPEG, TIFF or BMP file")
    _check_size(file, image.shape[1], image.shape[0])
    return image


def _check_size(file: Path, width: int, height: int) -> None:
    if min(width, height) < SMALLEST or max(width, height) > LARGEST or width * height > PIXELS:
        raise ImageError(
            f"photograph {file} has {width} x {height} pixels; {SMALLEST} x {SMALLEST} is the least, {LARGEST} a side "
            f"and {PIXELS / 1e6:g} megapixels are the most"
        )


def _decoded(data: Grey) -> Grey | None:
    level = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # what is wrong is said by us
    try:
        image = cv2.imdecode(data, cv2.IMREAD_GRAYSCALE)
    except (cv2.error, MemoryError):
        return None
    finally:
        cv2.utils.logging.setLogLevel(level)
    return None if image is None else image.astype(np.uint8)
