"""A map seen from above as SVG: paths, patches of floor and marks; world x to the right, y upwards, metres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from holonom.arrays import Array

__all__ = ["MapLine", "MapMark", "MapPatch", "TopView", "topview_svg"]


_WIDTH = 1080.0
_MARGIN = 36.0
_POINTS = 1500
_LEAST = 0.1
"""Extent (m) of the map of a base that hardly moves."""


@dataclass(frozen=True, slots=True)
class MapLine:
    """A path, points (N, 2)."""

    name: str
    points: Array
    colour: str
    dashed: bool = False


@dataclass(frozen=True, slots=True)
class MapPatch:
    """A patch of floor: the corners of a polygon (N, 2), and its name."""

    name: str
    corners: Array
    colour: str


@dataclass(frozen=True, slots=True)
class MapMark:
    """A named place (x, y)."""

    name: str
    place: tuple[float, float]
    colour: str


@dataclass(frozen=True, slots=True)
class TopView:
    """What the map shows, first patches, then lines, then marks."""

    title: str
    lines: Sequence[MapLine]
    patches: Sequence[MapPatch] = ()
    marks: Sequence[MapMark] = ()


def topview_svg(view: TopView) -> str:
    """The map, with a metre's grid and room for the names of marks."""
    points = np.concatenate([line.points for line in view.lines] + [patch.corners for patch in view.patches])
    low, high = _room(points)
    extent = high - low
    scale = (_WIDTH - 2 * _MARGIN) / extent[0]
    height = 2 * _MARGIN + scale * extent[1]

    def place(p: Array) -> Array:
        flat = np.asarray(p, dtype=float)
        return np.stack(
            [_MARGIN + scale * (flat[..., 0] - low[0]), height - _MARGIN - scale * (flat[..., 1] - low[1])], -1
        )

    body = _grid(low, high, place)
    body += "".join(_patch(patch, place(patch.corners)) for patch in view.patches)
    body += "".join(_line(line, place(line.points)) for line in view.lines)
    body += _marks(view.marks, np.array([place(np.array(mark.place)) for mark in view.marks]), height)
    return f'<svg viewBox="0 0 {_WIDTH:g} {height:.0f}" role="img" aria-label="{escape(view.title)}">{body}</svg>'


def _room(points: Array) -> tuple[Array, Array]:
    """Corners of what is shown: all points, no less than `_LEAST` either way, and no higher than wide."""
    low, high = points.min(axis=0), points.max(axis=0)
    wanted = np.maximum(high - low, _LEAST)
    wanted[0] = max(wanted)
    more = np.where(high - low < wanted, 0.5 * (wanted - (high - low)), 0.0)
    return low - more, high + more


def _grid(low: Array, high: Array, place: Callable[[Array], Array]) -> str:
    step = _step(float(max(high - low)))
    out = ""
    for x in _ticks(low[0], high[0], step):
        (x1, y1), (_, y2) = place(np.array([[x, low[1]], [x, high[1]]]))
        out += f'<line class="grid" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x1:.1f}" y2="{y2:.1f}"/>'
        out += f'<text class="value" x="{x1:.1f}" y="{y1 + 18:.1f}">{x:g} m</text>'
    for y in _ticks(low[1], high[1], step):
        (x1, y1), (x2, _) = place(np.array([[low[0], y], [high[0], y]]))
        out += f'<line class="grid" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y1:.1f}"/>'
        out += f'<text class="value" x="{x1 - 17:.1f}" y="{y1:.1f}">{y:g}</text>'
    return out


def _ticks(low: float, high: float, step: float) -> Array:
    ticks: Array = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0  # no -0
    return ticks


def _step(extent: float) -> float:
    decade = 10.0 ** np.floor(np.log10(extent / 4))
    return float(max(s * decade for s in (1, 2, 5) if s * decade <= extent / 4))


def _patch(patch: MapPatch, corners: Array) -> str:
    x, y = corners.mean(axis=0)
    return (
        f'<polygon class="patch" points="{_text(corners)}" style="fill:{escape(patch.colour)}"/>'
        f'<text x="{x:.1f}" y="{y:.1f}">{escape(patch.name)}</text>'
    )


def _line(line: MapLine, points: Array) -> str:
    thin = points[:: max(1, -(-len(points) // _POINTS))]
    dash = ' stroke-dasharray="2 7"' if line.dashed else ""
    return f'<polyline points="{_text(thin)}" style="stroke:{escape(line.colour)}"{dash}/>'


def _marks(marks: Sequence[MapMark], places: Array, height: float) -> str:
    """Dots with their names beside them, moved apart where they would overlap."""
    taken: list[tuple[float, float]] = []
    out = ""
    for mark, (x, y) in zip(marks, places, strict=True):
        ty = y - 12.0
        while any(abs(ty - other_y) < 15 and abs(x - other_x) < 150 for other_x, other_y in taken):
            ty += 15.0
        taken.append((x, ty))
        right = x > 0.62 * _WIDTH
        anchor, tx = ("end", x - 8) if right else ("start", x + 8)
        out += f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" style="fill:{escape(mark.colour)}"/>'
        at = f'x="{tx:.1f}" y="{min(ty, height - 6):.1f}" text-anchor="{anchor}"'
        out += f'<text class="mark" {at}>{escape(mark.name)}</text>'
    return out


def _text(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
