"""The courses that the laws are measured on: straight, circle, eight, chicane, parking."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from holonom.errors import InputError
from holonom.machine import PATHS, PathLimits, ReferencePath, plan_path
from holonom.mobile import WheelBase
from holonom.mobile.base.drivable import moves_sideways

__all__ = ["COURSES", "course"]

_CHICANE = ((0.0, 0.0), (1.5, 0.0), (3.0, 1.0), (4.5, 1.0), (6.0, 0.0), (7.5, 0.0))
COURSES: Mapping[str, tuple[str, Mapping[str, Any]]] = MappingProxyType({
    "straight": ("waypoints", {"points": ((0.0, 0.0), (5.0, 0.0))}),
    "circle": ("circle", {"size": 3.0}),
    "eight": ("figure_of_eight", {"size": 5.0}),
    "chicane": ("waypoints", {"points": _CHICANE}),
    "parking": ("reeds_shepp", {"poses": ((0.0, 0.0, 0.0), (0.0, 0.8, 0.0))}),
})  # fmt: skip
"""Course -> shape of its path, and what it is made of, m and rad."""
TIGHTEST = 0.6  # m, of parking
ROOM = 1.1  # radius of parking over the tightest that the base drives
ASTRAY = 1e-3  # m/s by which wheels may be dragged


def course(name: str, base: WheelBase, *, speed: float = 1.0, acceleration: float = 1.0) -> ReferencePath | None:
    """Return a course as a base drives it, m/s and m/s^2; None where it cannot.

    Bases that move sideways drive with a fixed heading; parking goes along its tangent.
    """
    shape, made_of = COURSES[name]
    limits, radius = PathLimits(speed, acceleration), base.turning_radius
    if shape == "reeds_shepp":
        if not np.isfinite(radius):
            return None
        return plan_path(PATHS.make(shape, {**made_of, "radius": max(ROOM * radius, TIGHTEST)}), limits)
    heading = "fixed" if moves_sideways(base) else "tangent"
    try:
        path = plan_path(PATHS.make(shape, made_of), limits, heading=heading)
    except InputError:
        return None
    away = (base.feasible(path.twist) - path.twist) * [1.0, 1.0, base.radius]
    return path if np.abs(away).max() < ASTRAY else None
