"""A map seen from above as SVG: paths, robots, patches of floor and marks; x to the right, y upwards, metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holonom.app.report.drawing.labels import Box, Room, text_size
from holonom.app.report.drawing.robot_map import LEGEND, MapRobot, robot_corners, robot_strokes, robot_svg, wheel_places
from holonom.app.report.markup import Html, colour, html, joined
from holonom.arrays import Array

__all__ = ["MapLine", "MapMark", "MapPatch", "TopView", "legend_of", "topview_svg"]

_MARGIN = (58.0, 34.0)
"""Left and below, and right and above: room for the ticks' numbers."""
APART = 80.0
"""Between two ticks at least."""
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
    """A patch of floor, or something that stands there: the corners of a polygon (N, 2), and its name."""

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
    """What the map shows, first patches, then robots, lines and marks; `width` is that of its picture, px."""

    title: str
    lines: Sequence[MapLine]
    patches: Sequence[MapPatch] = ()
    marks: Sequence[MapMark] = ()
    robots: Sequence[MapRobot] = ()
    width: float = 1080.0


@dataclass(frozen=True, slots=True)
class _Sheet:
    """Where the world lies on the page."""

    low: Array
    high: Array
    scale: float
    width: float
    height: float

    def place(self, points: Array) -> Array:
        """Points (..., 2) of the world on the page."""
        flat = np.asarray(points, dtype=float) - self.low
        x, y = _MARGIN[0] + self.scale * flat[..., 0], self.height - _MARGIN[0] + 14 - self.scale * flat[..., 1]
        return np.stack([x, y], -1)


def topview_svg(view: TopView) -> Html:
    """The map, with a metre's grid; names stand where they cover neither each other nor the paths."""
    sheet = _sheet(view)
    drawn = [_grid(sheet)]
    drawn += [_patch(patch, sheet.place(patch.corners)) for patch in view.patches]
    drawn += [robot_svg(robot, sheet.place) for robot in view.robots]
    drawn += [_line(line, sheet.place(line.points)) for line in view.lines]
    drawn += [_mark(mark, sheet.place(np.array(mark.place))) for mark in view.marks]
    drawn += _names(view, sheet)
    return html(
        '<svg viewBox="0 0 {:g} {:.0f}" role="img" aria-label="{}">{}</svg>',
        sheet.width, sheet.height, view.title, joined(drawn),
    )  # fmt: skip


def legend_of(view: TopView) -> list[tuple[str, str]]:
    """Names and colours of lines, and of what is drawn of robots."""
    lines = [(line.name, line.colour) for line in view.lines if line.name]
    if not view.robots:
        return lines
    outlines = [robot.outline for robot in view.robots]
    there = {
        "driven wheel": any(wheel.driven for outline in outlines for wheel in outline.wheels),
        "support polygon": any(outline.support is not None for outline in outlines),
        "centre of mass": any(outline.com is not None for outline in outlines),
        "centre of rotation": any(robot.centre is not None for robot in view.robots),
    }
    return [*lines, *((name, own) for name, own in LEGEND if there[name])]


def _sheet(view: TopView) -> _Sheet:
    parts = [np.asarray(line.points, dtype=float) for line in view.lines]
    parts += [np.asarray(patch.corners, dtype=float) for patch in view.patches]
    low, high = _room(np.concatenate([*parts, *map(robot_corners, view.robots)]))
    scale = (view.width - sum(_MARGIN)) / float(high[0] - low[0])
    return _Sheet(low, high, scale, view.width, sum(_MARGIN) - 14 + scale * float(high[1] - low[1]))


def _room(points: Array) -> tuple[Array, Array]:
    """Corners of what is shown: all points, no less than `_LEAST` either way, and no higher than wide."""
    low, high = points.min(axis=0), points.max(axis=0)
    wanted = np.maximum(high - low, _LEAST)
    wanted[0] = max(wanted)
    more = np.where(high - low < wanted, 0.5 * (wanted - (high - low)), 0.0)
    return low - more, high + more


def _grid(sheet: _Sheet) -> Html:
    """Lines at round metres with their numbers, and the names of the axes."""
    low, high, place = sheet.low, sheet.high, sheet.place
    step = _step(sheet)
    parts = []
    for x in _ticks(low[0], high[0], step):
        (x1, y1), (_, y2) = place(np.array([[x, low[1]], [x, high[1]]]))
        parts.append(_tick(x1, y1, x1, y2))
        parts.append(html('<text class="value" x="{:.1f}" y="{:.1f}">{:g} m</text>', x1, y1 + 16, x))
    for y in _ticks(low[1], high[1], step):
        (x1, y1), (x2, _) = place(np.array([[low[0], y], [high[0], y]]))
        parts.append(_tick(x1, y1, x2, y1))
        parts.append(html('<text class="value left" x="{:.1f}" y="{:.1f}">{:g} m</text>', x1 - 8, y1, y))
    left, bottom = place(low)
    right, top = place(high)
    parts.append(html('<text class="axis" x="{:.1f}" y="{:.1f}">x</text>', right + 16, bottom))
    parts.append(html('<text class="axis" x="{:.1f}" y="{:.1f}">y</text>', left, top - 14))
    return joined(parts)


def _tick(x1: float, y1: float, x2: float, y2: float) -> Html:
    return html('<line class="grid" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>', x1, y1, x2, y2)


def _ticks(low: float, high: float, step: float) -> Array:
    ticks: Array = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0  # no -0
    return ticks


def _step(sheet: _Sheet) -> float:
    """The least of 1, 2 or 5 tens whose numbers stand apart."""
    decade = 10.0 ** np.floor(np.log10(APART / sheet.scale))
    return float(next(s * decade for s in (1, 2, 5, 10) if s * decade * sheet.scale >= APART))


def _patch(patch: MapPatch, corners: Array) -> Html:
    return html('<polygon class="patch" points="{}" style="fill:{}"/>', _text(corners), colour(patch.colour))


def _line(line: MapLine, points: Array) -> Html:
    dash = Html(' stroke-dasharray="2 7"' if line.dashed else "")
    return html('<polyline points="{}" style="stroke:{}"{}/>', _text(_thin(points)), colour(line.colour), dash)


def _mark(mark: MapMark, at: Array) -> Html:
    return html('<circle cx="{:.1f}" cy="{:.1f}" r="4.5" style="fill:{}"/>', *at, colour(mark.colour))


def _names(view: TopView, sheet: _Sheet) -> list[Html]:
    """Names of marks, robots, their wheels, and patches, in this order of worth."""
    room = Room(sheet.width, sheet.height - _MARGIN[0] + 14)
    room.take(Box(0.0, 0.0, _MARGIN[0] - 4, sheet.height))  # the ticks' numbers
    for line in view.lines:
        room.cross(_thin(sheet.place(line.points)))
    for robot in view.robots:
        for stroke in robot_strokes(robot):
            room.cross(sheet.place(stroke))
    texts = [_name(mark.name, sheet.place(np.array(mark.place)), room, "mark") for mark in view.marks]
    for robot in view.robots:
        clear = sheet.scale * float(np.hypot(*robot.outline.skin.T).max())
        texts += [_name(robot.name, sheet.place(robot.pose[:2]), room, "mark", clear=clear)] if robot.name else []
        texts += [_name(text, sheet.place(at), room, "") for text, at in wheel_places(robot) if robot.named]
    middles = [(patch.name, sheet.place(patch.corners).mean(axis=0)) for patch in view.patches]
    return [*texts, *(_name(text, at, room, "", centred=True) for text, at in middles)]


def _name(text: str, at: Array, room: Room, kind: str, *, clear: float = 0.0, centred: bool = False) -> Html:
    x, y = (float(v) for v in at)
    found = room.place((x, y), text_size(text, bold=kind == "mark"), clear=clear, centred=centred)
    lead = html('<line class="lead" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}"/>', x, y, found.x, found.y)
    name = html('<text class="halo {}" x="{:.1f}" y="{:.1f}">{}</text>', kind, found.x, found.y, text)
    return joined([lead, name] if found.far else [name])


def _thin(points: Array) -> Array:
    return points[:: max(1, -(-len(points) // _POINTS))]


def _text(points: Array) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
