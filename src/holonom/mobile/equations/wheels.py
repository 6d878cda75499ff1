"""Rolling and sliding rows of one wheel (Siegwart & Nourbakhsh, Autonomous Mobile Robots, 3.2.3; specification 6.1).

A wheel stands at x = l cos(alpha), y = l sin(alpha); its axle points along alpha + beta. With s, c the sine and cosine
of alpha + beta the book's l cos(beta) is x c + y s and its l sin(beta) is x s - y c, so one angle is enough.
A row times the twist (vx, vy, w) of the base is a speed in m/s.
"""

from __future__ import annotations

import math

from holonom.trace import Number, cos, sin

__all__ = ["Row", "rolling_row", "sliding_row", "spin_row", "swedish_row"]

Row = list[Number]


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
    row = rolling_row(x, y, sin(axle + gamma), cos(axle + gamma))
    return [a / math.cos(gamma) for a in row]


def spin_row(radius: float) -> Row:
    """Rim speed of a ball that its drive spins about the vertical, while the ball stands still on the floor."""
    return [0.0, 0.0, radius]
