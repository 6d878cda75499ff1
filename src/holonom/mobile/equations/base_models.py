"""Rows of a whole base and its inverse model; traced, or on floats.

A base comes as a `Layout`. `axles` hold the sine and cosine of alpha + beta of every wheel: constants, or from the
steering angles. A wheel that steers alone needs neither: it runs at the speed of its contact point.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.equations.wheels import Row, contact_velocity, unit
from holonom.trace import Number, absolute, cos, maximum, sin

__all__ = ["Axle", "Layout", "axles_at", "drag", "rolling_rows", "sliding_rows", "speed_along", "wheel_speeds"]

Axle = tuple[Number, Number]


class Layout(NamedTuple):
    """Wheels, and the groups of steered wheels that turn together (indices into `wheels`); `radius` scales w."""

    wheels: tuple[Wheel, ...]
    groups: tuple[tuple[int, ...], ...]
    radius: float

    def axles(self, turned: Sequence[Axle]) -> list[Axle]:
        """Sine and cosine of alpha + beta of every wheel, of those in groups from sine and cosine of the angle."""
        axles: list[Axle] = [unit(w.axle) for w in self.wheels]
        for members, (sd, cd) in zip(self.groups, turned, strict=True):
            for i in members:
                s, c = axles[i]
                axles[i] = (s * cd + c * sd, c * cd - s * sd)
        return axles


def axles_at(layout: Layout, steering: Sequence[Number]) -> list[Axle]:
    """The axles at steering angles, one angle per group."""
    return layout.axles([(sin(angle), cos(angle)) for angle in steering])


def rolling_rows(layout: Layout, axles: Sequence[Axle], *, driven: bool = True) -> list[tuple[Wheel, Row]]:
    """Rolling rows of the driven wheels, or of all, each with its wheel."""
    chosen = [(w, a) for w, a in zip(layout.wheels, axles, strict=True) if w.driven or not driven]
    return [(w, row) for w, (s, c) in chosen for row in KINDS[w.kind].rolling(w, s, c)]


def sliding_rows(layout: Layout, axles: Sequence[Axle]) -> list[tuple[Wheel, Row]]:
    """Rows of all wheels that must not slide sideways, each with its wheel."""
    pairs = zip(layout.wheels, axles, strict=True)
    return [(w, row) for w, (s, c) in pairs for row in KINDS[w.kind].sliding(w, s, c)]


def speed_along(wheel: Wheel, row: Row, twist: Row) -> Number:
    """A row of the wheel times the twist; of a wheel with an axle by way of the velocity that its rows share."""
    if wheel.kind not in ("fixed", "steered"):
        return row[0] * twist[0] + row[1] * twist[1] + row[2] * twist[2]
    ux, uy = contact_velocity(wheel.x, wheel.y, twist)
    return row[0] * ux + row[1] * uy


def wheel_speeds(layout: Layout, twist: Row, axles: Sequence[Axle]) -> Row:
    """Inverse model: rad/s of the driven speeds."""
    return [speed_along(w, row, twist) / w.radius for w, row in rolling_rows(layout, axles)]


def drag(layout: Layout, twist: Row, axles: Sequence[Axle]) -> Number:
    """Largest sideways speed of a wheel that must not slide, m/s."""
    sideways = [absolute(speed_along(w, row, twist)) for w, row in sliding_rows(layout, axles)]
    worst: Number = sideways[0] if sideways else 0.0
    for speed in sideways[1:]:
        worst = maximum(worst, speed)
    return worst
