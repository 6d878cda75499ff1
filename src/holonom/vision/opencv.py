"""OpenCV, or the word for what to do without: everything else of Holonom works."""

from __future__ import annotations

from holonom.errors import MissingExtra

__all__ = ["cv2"]

try:
    import cv2
except ImportError as error:
    raise MissingExtra("a photograph", "OpenCV", "vision") from error
