"""A polar plot as SVG: a quantity by direction in the robot frame, x forwards (up), y to the left."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

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


def polar_svg(polar: Polar) -> str:
    """The plot: rings with their values, directions, closed lines."""
    largest = max(float(np.max(line.values)) for line in polar.lines)
    step = _ring_step(largest)
    rings = max(1, math.ceil(largest / step - 1e-3))
    scale = _RADIUS / (step * rings)
    body = "".join(_ring(k * step, scale, polar.unit if k == rings else "") for k in range(1, rings + 1))
    body += "".join(_spoke(math.radians(degrees), degrees) for degrees in range(0, 360, 45))
    body += "".join(_line(line, scale) for line in polar.lines)
    return f'<svg viewBox="0 0 {_SIDE:g} {_SIDE:g}" role="img" aria-label="{escape(polar.title)}">{body}</svg>'


def _at(angle: float, radius: float) -> tuple[float, float]:
    """Place of a direction on the page: x upwards, y to the left."""
    return _SIDE / 2 - radius * math.sin(angle), _SIDE / 2 - radius * math.cos(angle)


def _ring(value: float, scale: float, unit: str) -> str:
    radius = value * scale
    x, y = _at(math.radians(-22.5), radius)
    text = f"{value:.3g} {unit}".strip()
    return (
        f'<circle class="grid" cx="{_SIDE / 2:g}" cy="{_SIDE / 2:g}" r="{radius:.1f}"/>'
        f'<text class="value" x="{x:.1f}" y="{y:.1f}">{escape(text)}</text>'
    )


def _spoke(angle: float, degrees: int) -> str:
    x, y = _at(angle, _RADIUS)
    tx, ty = _at(angle, _RADIUS + 18)
    text = {0: "forwards", 90: "left", 180: "backwards", 270: "right"}.get(degrees, f"{degrees}°")
    return (
        f'<line class="grid" x1="{_SIDE / 2:g}" y1="{_SIDE / 2:g}" x2="{x:.1f}" y2="{y:.1f}"/>'
        f'<text x="{tx:.1f}" y="{ty:.1f}">{text}</text>'
    )


def _line(line: PolarLine, scale: float) -> str:
    points = [_at(float(a), float(v) * scale) for a, v in zip(line.angles, line.values, strict=True)]
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    colour = escape(line.colour)
    return f'<polygon points="{text}" style="stroke:{colour};fill:{colour}"/>'


def _ring_step(largest: float) -> float:
    """The least ring distance of 1, 2, 2.5 or 5 tens with which few enough rings hold the largest value."""
    if largest <= 0.0:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(largest / _RINGS))
    return next(step * decade for step in (1.0, 2.0, 2.5, 5.0, 10.0) if step * decade * _RINGS >= largest * 0.999)
