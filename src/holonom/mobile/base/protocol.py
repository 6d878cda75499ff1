"""What the code below `WheelBase` knows of a base: its layout and constraint rows, but not the class."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mobile.equations.base_models import Layout

__all__ = ["ConstrainedBase"]


class ConstrainedBase(Protocol):
    """Wheels on one body, as those see it who ask about its constraints; `WheelBase` is one."""

    name: str
    radius: float
    layout: Layout
    driven: tuple[str, ...]
    steered: tuple[str, ...]
    sliding_names: tuple[str, ...]

    def steering(self, twist: ArrayLike) -> Array:
        """Angles (..., k), rad, that put each steered axle through the centre of rotation."""

    def sliding_matrix(self, steering: ArrayLike | None = None) -> Array:
        """Rows (..., rows, 3) that times the twist give the sideways speeds, m/s."""
