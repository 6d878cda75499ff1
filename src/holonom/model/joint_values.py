"""Joint values as people read them: with the unit of the joint's kind, and whether degrees came for radians."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["in_degrees", "looks_like_degrees", "range_in_degrees", "written"]

_TURNS = 4.0 * math.pi
"""rad from which an angle outside its limits is more likely one in degrees."""


def written(value: float, turns: bool) -> str:
    """Return a joint value in rad with its degrees, or in m: "0.785398 rad (45 deg)", "0.5 m"."""
    return f"{value:.6g} rad ({in_degrees(value, turns)})" if turns else f"{value:.6g} m"


def in_degrees(value: float, turns: bool) -> str:
    """Return a joint value as programs write it: degrees of a joint that turns, mm of one that slides."""
    return f"{math.degrees(value):.6g} deg" if turns else f"{1e3 * value:.6g} mm"


def range_in_degrees(low: float, high: float, turns: bool) -> str:
    """Return the limits of a joint as programs write them: "-225 to 45 deg", "0 to 210 mm"."""
    return f"{in_degrees(low, turns).rpartition(' ')[0]} to {in_degrees(high, turns)}"


def looks_like_degrees(q: ArrayLike, lower: ArrayLike, upper: ArrayLike, turns: Sequence[bool]) -> bool:
    """Whether angles (n,) that came as radians look like degrees.

    They do where one lies above 4 pi and outside its limits, and all would lie within theirs as degrees.
    """
    values, turning = np.asarray(q, float), np.asarray(turns, bool)
    low, high = np.asarray(lower, float), np.asarray(upper, float)
    far = turning & (np.abs(values) > _TURNS) & ((values < low) | (values > high))
    as_degrees = np.radians(values)
    fits = (as_degrees >= low - 1e-9) & (as_degrees <= high + 1e-9)
    return bool(far.any() and fits[turning].all())
