"""A polar plot as SVG: a quantity by direction in the robot frame, x forwards (up), y to the left."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holonom.app.report.drawing.labels import Box, Room, text_size
from holonom.app.report.markup import Html, colour, html, joined
from holonom.arrays import Array

__all__ = ["Polar", "PolarLine", "polar_svg"]


_SIDE = 320.0
_RADIUS = 118.0
_RINGS = 4
"""At most so many."""


@dataclass(frozen=True, slots=True)
class PolarLine:
    """`values` (N,) by direction `angles` (N,) in rad, counter-clockwise from x."""

    name: str
    angles: Array
    values: Array
    colour: str


@dataclass(frozen=True, slots=True)
class Polar:
    """Lines of one quantity in `unit`."""

    title: str
    unit: str
    lines: Sequence[PolarLine]


def polar_svg(polar: Polar) -> Html:
    """The plot: rings with their values, directions, closed lines."""
    largest = max(float(np.max(line.values)) for line in polar.lines)
    step = _ring_step(largest)
    rings = max(1, math.ceil(largest / step - 1e-3))
    scale = _RADIUS / (step * rings)
    lines = [_points(line, scale) for line in polar.lines]
    values = [
        (f"{k * step:.3g} {polar.unit if k == rings else ''}".strip(), k * step * scale) for k in range(1, rings + 1)
    ]
    circles = (
        html('<circle class="grid" cx="{0:g}" cy="{0:g}" r="{1:.1f}"/>', _SIDE / 2, radius) for _, radius in values
    )
    spokes = (_spoke(math.radians(degrees), degrees) for degrees in range(0, 360, 45))
    drawn = (_line(line.colour, points) for line, points in zip(polar.lines, lines, strict=True))
    body = joined([*circles, *spokes, *drawn, *_values(values, lines)])
    return html('<svg viewBox="0 0 {0:g} {0:g}" role="img" aria-label="{1}">{2}</svg>', _SIDE, polar.title, body)


def _values(values: Sequence[tuple[str, float]], lines: Sequence[Array]) -> list[Html]:
    """Values of rings, all in that direction between two spokes in which they cover least of the lines."""
    room = Room(_SIDE, _SIDE)
    for points in lines:
        room.cross(np.concatenate([points, points[:1]]))

    def boxes(angle: float) -> list[Box]:
        sized = ((_at(angle, radius), text_size(text, 11.0)) for text, radius in values)
        return [Box(x - 0.5 * w, y - 0.5 * h, x + 0.5 * w, y + 0.5 * h) for (x, y), (w, h) in sized]

    angles = [math.radians(degrees) for degrees in (-22.5, 22.5, 157.5, -157.5, 67.5, -67.5, 112.5, -112.5)]
    best = min(angles, key=lambda angle: sum(room.cost(box) for box in boxes(angle)))
    return [
        html('<text class="value" x="{:.1f}" y="{:.1f}">{}</text>', *_at(best, radius), text) for text, radius in values
    ]


def _at(angle: float, radius: float) -> tuple[float, float]:
    """Place of a direction on the page: x upwards, y to the left."""
    return _SIDE / 2 - radius * math.sin(angle), _SIDE / 2 - radius * math.cos(angle)


def _spoke(angle: float, degrees: int) -> Html:
    x, y = _at(angle, _RADIUS)
    tx, ty = _at(angle, _RADIUS + 18)
    text = {0: "forwards", 90: "left", 180: "backwards", 270: "right"}.get(degrees, f"{degrees}°")
    return html(
        '<line class="grid" x1="{0:g}" y1="{0:g}" x2="{1:.1f}" y2="{2:.1f}"/><text x="{3:.1f}" y="{4:.1f}">{5}</text>',
        _SIDE / 2, x, y, tx, ty, text,
    )  # fmt: skip


def _points(line: PolarLine, scale: float) -> Array:
    """Its points (N, 2) on the page."""
    return np.array([_at(float(a), float(v) * scale) for a, v in zip(line.angles, line.values, strict=True)])


def _line(own: str, points: Array) -> Html:
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return html('<polygon points="{0}" style="stroke:{1};fill:{1}"/>', text, colour(own))


def _ring_step(largest: float) -> float:
    """The least ring distance of 1, 2, 2.5 or 5 tens with which few enough rings hold the largest value."""
    if largest <= 0.0:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(largest / _RINGS))
    return next(step * decade for step in (1.0, 2.0, 2.5, 5.0, 10.0) if step * decade * _RINGS >= largest * 0.999)
