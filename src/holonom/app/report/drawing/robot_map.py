"""Robots on a map: outline, heading, wheels, support polygon, centre of mass, centre of rotation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from holonom.app.report.markup import Html, html, joined
from holonom.arrays import Array

__all__ = [
    "LEGEND",
    "MapRobot",
    "RobotOutline",
    "WheelOutline",
    "robot_corners",
    "robot_strokes",
    "robot_svg",
    "wheel_places",
]

SKIN, WHEEL, IDLE, SUPPORT, MASS, CENTRE = "#64748b", "#33415c", "#94a3b8", "#9c6f00", "#c2255c", "#5f3dc4"
LEGEND = (
    ("driven wheel", WHEEL), ("support polygon", SUPPORT), ("centre of mass", MASS), ("centre of rotation", CENTRE),
)  # fmt: skip
WIDE = 0.45
"""Width of a drawn wheel over its radius, as in the replay."""


@dataclass(frozen=True, slots=True)
class WheelOutline:
    """A wheel from above: where it stands (x, y) m and the way it rolls, rad, in base_link; a castor's pivot."""

    name: str
    place: tuple[float, float]
    heading: float
    radius: float
    driven: bool = True
    ball: bool = False
    pivot: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class RobotOutline:
    """A base from above, in base_link: skin (N, 2) m, wheels, support polygon (k, 2) m, centre of mass (x, y) m."""

    skin: Array
    wheels: tuple[WheelOutline, ...]
    support: Array | None = None
    com: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class MapRobot:
    """A robot at `pose` (3,) x, y, theta; `name` stands beside it, "" does not.

    `centre` is its centre of rotation (x, y) in the world, if it has one in reach; `named` says whether its wheels'
    names stand there.
    """

    outline: RobotOutline
    pose: Array
    name: str = ""
    centre: tuple[float, float] | None = None
    named: bool = False


Placing = Callable[[Array], Array]


def robot_corners(robot: MapRobot) -> Array:
    """Points (N, 2) of all that is drawn of a robot, in the world."""
    parts = [robot.outline.skin, _arrow(robot.outline), *map(_tread, robot.outline.wheels)]
    centre = [] if robot.centre is None else [np.array([robot.centre])]
    return np.concatenate([*(_turned(robot.pose, part) for part in parts), *centre])


def robot_strokes(robot: MapRobot) -> list[Array]:
    """Lines (N, 2) in the world that names keep clear of: outlines, arrow, and wheels, filled."""
    outline = robot.outline
    lines = [np.concatenate([outline.skin, outline.skin[:1]]), _arrow(outline)]
    for wheel in outline.wheels:
        tread = _tread(wheel)
        ends = np.linspace(tread[: len(tread) // 2], tread[: len(tread) // 2 - 1 : -1], 5)
        lines += list(ends)
    if outline.support is not None:
        lines.append(np.concatenate([outline.support, outline.support[:1]]))
    return [_turned(robot.pose, line) for line in lines]


def wheel_places(robot: MapRobot) -> list[tuple[str, Array]]:
    """Names and places (2,) of its wheels, in the world."""
    return [(wheel.name, _turned(robot.pose, np.array([wheel.place]))[0]) for wheel in robot.outline.wheels]


def robot_svg(robot: MapRobot, place: Placing) -> Html:
    """A robot on a map; `place` takes points (N, 2) of the world to the page."""

    def on_page(points: Array) -> Array:
        return place(_turned(robot.pose, points))

    outline = robot.outline
    parts = [_shape("skin", on_page(outline.skin), SKIN)]
    if outline.support is not None:
        parts.append(_shape("support", on_page(outline.support), SUPPORT))
    for wheel in outline.wheels:
        if wheel.pivot is not None:
            parts.append(_bar(on_page(np.array([wheel.pivot, wheel.place])), IDLE))
        parts.append(_shape("wheel", on_page(_tread(wheel)), WHEEL if wheel.driven else IDLE))
    ends = on_page(_arrow(outline))
    parts += [_bar(ends[:2], SKIN), _shape("head", ends[1:], SKIN)]
    if outline.com is not None:
        (x, y) = on_page(np.array([outline.com]))[0]
        parts.append(html('<path class="mass" d="M{0:.1f} {1:.1f}m-4 0h8m-4 -4v8" style="stroke:{2}"/>', x, y, MASS))
    if robot.centre is not None:
        parts += _centre(place(np.array([robot.pose[:2], robot.centre])))
    return html('<g class="robot">{}</g>', joined(parts))


def _centre(ends: Array) -> list[Html]:
    """A cross where the base turns about, and how far that is from its middle."""
    line = html(
        '<line class="radius" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" style="stroke:{}"/>',
        *ends.ravel(),
        CENTRE,
    )
    cross = html('<path class="mass" d="M{:.1f} {:.1f}m-4 -4l8 8m0 -8l-8 8" style="stroke:{}"/>', *ends[1], CENTRE)
    return [line, cross]


def _tread(wheel: WheelOutline) -> Array:
    """Corners of a wheel from above: a rectangle along the way it rolls, of a ball a circle."""
    if wheel.ball:
        turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        return np.array(wheel.place) + wheel.radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    half = wheel.radius * np.array([[1, 0.5 * WIDE], [-1, 0.5 * WIDE], [-1, -0.5 * WIDE], [1, -0.5 * WIDE]])
    return _turned(np.array([*wheel.place, wheel.heading]), half)


def _arrow(outline: RobotOutline) -> Array:
    """From the origin forwards (5, 2): start and end of the shaft, then the head's other corners and its middle."""
    front = float(np.max(outline.skin[:, 0]))
    size = max(front, 0.3 * float(np.ptp(outline.skin[:, 0])))
    tip, back, half = front + 0.26 * size, front + 0.06 * size, 0.1 * size
    return np.array([[0.0, 0.0], [back, 0.0], [back, half], [tip, 0.0], [back, -half]])


def _turned(pose: Array, points: Array) -> Array:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    moved: Array = np.asarray(points) @ np.array([[c, s], [-s, c]]) + np.asarray(pose)[:2]
    return moved


def _shape(kind: str, points: Array, own: str) -> Html:
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return html('<polygon class="{}" points="{}" style="stroke:{};fill:{}"/>', kind, text, own, own)


def _bar(ends: Array, own: str) -> Html:
    return html(
        '<line class="bar" x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" style="stroke:{}"/>', *ends.ravel(), own
    )
