"""Bodies of simple shape, for the presets whose masses are made up."""

from __future__ import annotations

from typing import Literal

from holonom.model.arm import Body

__all__ = ["cylinder"]


def cylinder(mass: float, length: float, radius: float, along: Literal["x", "y", "z"], start: float = 0.0) -> Body:
    """Return a homogeneous solid cylinder (kg, m) whose axis is a frame's axis, from `start` to `start + length` on it.

    Moments about the centre: m r^2 / 2 along the axis, m (3 r^2 + l^2) / 12 across.
    """
    k = "xyz".index(along)
    centre = start + 0.5 * length
    inertia = [mass * (3 * radius**2 + length**2) / 12] * 3
    inertia[k] = 0.5 * mass * radius**2
    com = [centre if i == k else 0.0 for i in range(3)]
    return Body(mass, (com[0], com[1], com[2]), (inertia[0], inertia[1], inertia[2], 0.0, 0.0, 0.0))
