"""What things are for those who must not hit them: boxes and cylinders, about their own middle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError

__all__ = ["Box", "Cylinder", "Shape", "outline"]

ROUND = 48
"""Corners of the outline of a cylinder."""


@dataclass(frozen=True, slots=True)
class Box:
    """Length, width and height along x, y and z, m."""

    size: tuple[float, float, float]

    def __post_init__(self) -> None:
        _positive("box", *self.size)

    @property
    def height(self) -> float:
        """Along z, m."""
        return self.size[2]

    @property
    def reach(self) -> float:
        """Of its farthest point from its middle, m."""
        return 0.5 * math.hypot(*self.size)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """About z: radius and height, m."""

    radius: float
    height: float

    def __post_init__(self) -> None:
        _positive("cylinder", self.radius, self.height)

    @property
    def reach(self) -> float:
        """Of its farthest point from its middle, m."""
        return math.hypot(self.radius, 0.5 * self.height)


Shape = Box | Cylinder


def outline(shape: Shape) -> Array:
    """Corners (k, 2) of a shape seen from above, counter-clockwise, m."""
    if isinstance(shape, Box):
        return 0.5 * np.array(shape.size[:2]) * np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND, endpoint=False)
    return shape.radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)


def _positive(what: str, *sizes: float) -> None:
    for size in sizes:
        if not (size >= 0.0 and math.isfinite(size)):
            raise ModelError(f"a {what} measures {size} m; a finite size that is not below zero is needed")
