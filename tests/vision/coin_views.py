"""Ways to take the photograph of the demo again from elsewhere."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

PHOTOGRAPH = Path(__file__).parents[2] / "examples" / "01_sort_coins" / "coins.png"


def retake(image, *, turn=0.0, scale=1.0, tilt=(0.0, 0.0), fill="black", canvas="enlarged"):
    """Image turned (degrees), scaled and tilted (1/pixel) about its middle; and the matrix old -> new pixel.

    `canvas`: "enlarged" to hold all of it, or "same" size (for turns and scales that cut no coin).
    `fill`: what is beyond its border: "black", "grey" (its mean) or "replicate".
    """
    height, width = image.shape
    middle = np.array([[1.0, 0.0, -(width - 1) / 2], [0.0, 1.0, -(height - 1) / 2], [0.0, 0.0, 1.0]])
    c, s = scale * np.cos(np.radians(turn)), scale * np.sin(np.radians(turn))
    matrix = np.array([[c, -s, 0.0], [s, c, 0.0], [*tilt, 1.0]]) @ middle
    if canvas == "enlarged":
        corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], float)
        seen = through(matrix, corners)
        low, size = seen.min(axis=0), tuple(int(x) for x in np.ceil(np.ptp(seen, axis=0)) + 1)
        matrix = np.array([[1.0, 0.0, -low[0]], [0.0, 1.0, -low[1]], [0.0, 0.0, 1.0]]) @ matrix
    else:
        matrix, size = np.linalg.inv(middle) @ matrix, (width, height)
    border = cv2.BORDER_REPLICATE if fill == "replicate" else cv2.BORDER_CONSTANT
    value = {"black": 0.0, "grey": float(image.mean()), "replicate": 0.0}[fill]
    return cv2.warpPerspective(image, matrix, size, flags=cv2.INTER_CUBIC, borderMode=border, borderValue=value), matrix


def through(matrix, points):
    image = np.column_stack([points, np.ones(len(points))]) @ np.asarray(matrix).T
    return image[:, :2] / image[:, 2:]
