"""Rolling and sliding rows of one wheel (Siegwart & Nourbakhsh, Autonomous Mobile Robots, 3.2.3; specification 6.1).

A wheel stands at x = l cos(alpha), y = l sin(alpha); its axle points along alpha + beta. With s, c the sine and cosine
of alpha + beta the book's l cos(beta) is x c + y s and its l sin(beta) is x s - y c, so one angle is enough.
A row times the twist (vx, vy, w) of the base is a speed in m/s.
"""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Iterable

from holonom.trace import Number

__all__ = ["Row", "contact_velocity", "rolling_row", "sliding_row", "spin_row", "summed", "swedish_row", "unit"]

Row = list[Number]
ROUNDING = 1e-15
"""Sine or cosine, and place over distance, that is 0 but for the rounding of an angle."""


def unit(angle: float) -> tuple[float, float]:
    """Sine and cosine, exactly 0 and +-1 at quarter turns: what is 0 then drops out of compiled equations."""
    s, c = math.sin(angle), math.cos(angle)
    if abs(s) < ROUNDING:
        return 0.0, math.copysign(1.0, c)
    return (math.copysign(1.0, s), 0.0) if abs(c) < ROUNDING else (s, c)


def contact_velocity(x: float, y: float, twist: Row) -> tuple[Number, Number]:
    """Velocity of the base at (x, y), m/s: times the unit vector of a row it is that row times the twist."""
    return twist[0] - y * twist[2], twist[1] + x * twist[2]


def rolling_row(x: float, y: float, s: Number, c: Number) -> Row:
    """[sin(alpha+beta), -cos(alpha+beta), -l cos(beta)]: times the twist it is r phid (3.6)."""
    return [s, -c, -(x * c + y * s)]


def sliding_row(x: float, y: float, s: Number, c: Number) -> Row:
    """[cos(alpha+beta), sin(alpha+beta), l sin(beta)]: times the twist it is the speed along the axle (3.7)."""
    return [c, s, x * s - y * c]


def swedish_row(x: float, y: float, axle: float, gamma: float) -> Row:
    """[sin(a+b+g), -cos(a+b+g), -l cos(b+g)] / cos(gamma): times the twist it is r phid (3.12).

    What lies across is lost to the rollers. `axle` is alpha + beta.
    """
    row = rolling_row(x, y, *unit(axle + gamma))
    return [a / math.cos(gamma) for a in row]


def spin_row(radius: float) -> Row:
    """Rim speed of a ball that its drive spins about the vertical, while the ball stands still on the floor."""
    return [0.0, 0.0, radius]


def summed(terms: Iterable[Number]) -> Number:
    """Sum of at least one term; unlike `sum` it adds no zero."""
    return functools.reduce(operator.add, terms)
