"""Where names stand in a drawing: beside what they name, clear of each other and of the lines drawn."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array

__all__ = ["Box", "Place", "Room", "text_size"]

CELL = 5.0
"""Width of the squares by which it is known where lines are, in the drawing's units."""
AWAY = (11.0, 18.0, 28.0, 42.0, 60.0, 84.0, 112.0)
WIDE = 60.0
"""Reach of what is named, from which on a line joins it to its name."""
DIRECTIONS = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (1, 1), (-1, -1), (-1, 1))
"""Sides on which a name is tried, in this order."""


class Box(NamedTuple):
    """A box in the drawing, x to the right and y down."""

    x1: float
    y1: float
    x2: float
    y2: float

    def overlap(self, other: Box) -> float:
        """Area that both cover."""
        wide = min(self.x2, other.x2) - max(self.x1, other.x1)
        high = min(self.y2, other.y2) - max(self.y1, other.y1)
        return max(wide, 0.0) * max(high, 0.0)


class Place(NamedTuple):
    """Middle of a name, and whether it stands so far off that a line must join it to what it names."""

    x: float
    y: float
    far: bool


def text_size(text: str, size: float = 12.0, *, bold: bool = False) -> tuple[float, float]:
    """Width and height of a line of text, generously."""
    return max(len(text), 1) * size * (0.64 if bold else 0.58), 1.25 * size


class Room:
    """What is taken of a drawing: squares that lines cross, and boxes."""

    __slots__ = ("_crossed", "_height", "_taken", "_width")

    def __init__(self, width: float, height: float) -> None:
        self._width, self._height = width, height
        self._crossed = np.zeros((int(height / CELL) + 2, int(width / CELL) + 2), dtype=bool)
        self._taken: list[Box] = []

    def cross(self, points: Array) -> None:
        """Take the squares along a line through points (N, 2)."""
        points = np.asarray(points, dtype=float)
        for start, end in pairwise(points):
            count = int(np.hypot(*(end - start)) / CELL) + 2
            self._mark(np.linspace(start, end, count))

    def take(self, box: Box) -> None:
        """Take a box."""
        self._taken.append(box)

    def place(
        self, anchor: tuple[float, float], size: tuple[float, float], *, clear: float = 0.0, centred: bool = False
    ) -> Place:
        """Take the first free place for a name of this size by its anchor, or else the one that covers least.

        `clear` is how far around the anchor what it names reaches; with `centred` the anchor itself is tried first.
        """
        x, y = anchor
        wide, high = size
        tried = [(x, y, 0.0)] if centred else []
        tried += [
            (x + dx * (away + clear + 0.5 * wide), y + dy * (away + clear + 0.5 * high), away) if dx == 0 or dy == 0
            else (x + dx * (0.7 * (away + clear) + 0.5 * wide), y + dy * (0.7 * (away + clear) + 0.5 * high), away)
            for away in AWAY for dx, dy in DIRECTIONS
        ]  # fmt: skip
        best = min((self.cost(_around(a, b, size)) + 1e-3 * k, k) for k, (a, b, _) in enumerate(tried))
        a, b, away = tried[best[1]]
        a = float(np.clip(a, 0.5 * wide, max(self._width - 0.5 * wide, 0.5 * wide)))
        b = float(np.clip(b, 0.5 * high, max(self._height - 0.5 * high, 0.5 * high)))
        self._taken.append(_around(a, b, size))
        return Place(a, b, away > AWAY[1] or clear > WIDE)

    def cost(self, box: Box) -> float:
        """What a name would cover: other names above all, then lines; what is not in the drawing at all."""
        covered = 10.0 * sum(box.overlap(other) for other in self._taken)
        outside = max(-box.x1, 0.0) + max(-box.y1, 0.0) + max(box.x2 - self._width, 0.0) + max(box.y2 - self._height, 0)
        rows = slice(max(int(box.y1 / CELL), 0), max(int(box.y2 / CELL) + 1, 0))
        columns = slice(max(int(box.x1 / CELL), 0), max(int(box.x2 / CELL) + 1, 0))
        return covered + 1e4 * outside + CELL * CELL * float(np.count_nonzero(self._crossed[rows, columns]))

    def _mark(self, points: Array) -> None:
        rows, columns = self._crossed.shape
        i, j = (points[:, 1] / CELL).astype(int), (points[:, 0] / CELL).astype(int)
        inside = (i >= 0) & (i < rows) & (j >= 0) & (j < columns)
        self._crossed[i[inside], j[inside]] = True


def _around(x: float, y: float, size: Sequence[float]) -> Box:
    return Box(x - 0.5 * size[0], y - 0.5 * size[1], x + 0.5 * size[0], y + 0.5 * size[1])
