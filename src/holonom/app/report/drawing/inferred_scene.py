"""A scene for a recording that brings none: tubes between the links of arms, wheels, and axes of all other frames."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from holonom.app.recording import FrameTrack
from holonom.app.report.drawing.scene import Box, Disc, Scene, Shape, Tube, View
from holonom.arrays import Array

__all__ = ["inferred_scene"]

BODY, JOINT, METAL, RUBBER, PART = "#eef1f5", "#33415c", "#aab4c3", "#1f2937", "#b08d57"
AXES = ("#c92a2a", "#2b8a3e", "#1864ab")
LINK, WHEEL = re.compile(r"(?:.*_)?link_?(\d+)$"), re.compile(r"wheel_?\d+$")
NUMBERED = re.compile(r".*_\d+$")
SAMPLES = 40
"""Moments at which frames are compared."""


def inferred_scene(frames: Mapping[str, FrameTrack]) -> Scene:
    """What can be drawn of frames (by their full names) of which nothing more is known."""
    if not frames:
        return Scene((), tool="world")
    robots: dict[str, list[str]] = defaultdict(list)
    for name in frames:
        robots[name.rpartition("/")[0]].append(name)
    low, high = _room(frames)
    size = float(np.clip(np.max(high - low), 0.2, 40.0))
    shapes = [shape for names in robots.values() for shape in _robot(names, frames, size)]
    centre = 0.5 * (low + high)
    extent = float(max(np.abs([low, high])[:, :2].max() + 0.3 * size, 0.5))
    views = _views(centre, size, _first(frames, "base_link"))
    return Scene(tuple(shapes), views, tool=_tool(frames), trail=1e3, extent=extent)


def _room(frames: Mapping[str, FrameTrack]) -> tuple[Array, Array]:
    """Corners (3,) of what frames move in, and the world's origin."""
    places = np.concatenate([np.zeros((1, 3)), *(track.position for track in frames.values())])
    return places.min(axis=0), places.max(axis=0)


def _tool(frames: Mapping[str, FrameTrack]) -> str:
    most = max(frames, key=lambda name: float(np.ptp(frames[name].position, axis=0).sum()))
    return _first(frames, "tool") or _first(frames, "base_link") or most


def _first(frames: Mapping[str, FrameTrack], wanted: str) -> str | None:
    """Full name of the first frame that a robot calls so."""
    return next((name for name in frames if name.rpartition("/")[2] == wanted), None)


def _robot(names: Sequence[str], frames: Mapping[str, FrameTrack], size: float) -> list[Shape]:
    own = {name.rpartition("/")[2]: name for name in names}
    links = sorted((name for name in own if LINK.match(name) and name != "base_link"), key=_number)
    chain = [own[name] for name in (*links, *(name for name in ("tool",) if name in own and links))]
    shapes = _chain(chain, frames, size)
    wheels = [own[name] for name in own if WHEEL.match(name)]
    shapes += [shape for wheel in wheels for shape in _wheel(frames[wheel], wheel)]
    if "base_link" in own and wheels:
        shapes += _body(own["base_link"], [frames[wheel] for wheel in wheels], frames[own["base_link"]])
    drawn = {*chain, *wheels} | ({own["base_link"]} if "base_link" in own and wheels else set())
    for name in names:
        if name not in drawn:
            shapes += [_part(name)] if NUMBERED.match(name) else _axes(name, 0.04 * size)
    return shapes


def _number(name: str) -> int:
    found = LINK.match(name)
    return int(found[1]) if found else 0


def _chain(names: Sequence[str], frames: Mapping[str, FrameTrack], size: float) -> list[Shape]:
    """A tube from each frame to the next, in that of the two in which the other stands still."""
    thick = 0.03 * min(size, 1.5)
    shapes: list[Shape] = []
    if names:
        foot = tuple(map(float, frames[names[0]].position[0]))
        shapes.append(Tube("world", (foot[0], foot[1], 0.0), (foot[0], foot[1], foot[2]), 1.3 * thick, JOINT))
    for k, (one, other) in enumerate(pairwise(names)):
        there, back = _seen(frames[one], frames[other]), _seen(frames[other], frames[one])
        frame, ends = (one, there) if np.ptp(there, axis=0).sum() <= np.ptp(back, axis=0).sum() else (other, back)
        x, y, z = map(float, ends.mean(axis=0))
        shapes.append(Box(frame, np.eye(4), (2.2 * thick,) * 3, JOINT))
        if np.linalg.norm((x, y, z)) > 1e-3:
            radius = max(thick * (1 - 0.08 * k), 0.4 * thick)
            shapes.append(Tube(frame, (0, 0, 0), (x, y, z), radius, BODY, rounded=True))
    shapes += _axes(names[-1], 0.06 * size) if names else []
    return [shape for shape in shapes if not (isinstance(shape, Tube) and shape.start == shape.end)]


def _seen(one: FrameTrack, other: FrameTrack) -> Array:
    """Places (N, 3) of the second frame's origin in the first, at some of the first one's moments."""
    at = np.unique(np.linspace(0, len(one.time) - 1, SAMPLES).astype(int))
    then = np.clip(np.searchsorted(other.time, one.time[at] + 1e-9) - 1, 0, len(other.time) - 1)
    some = FrameTrack(one.time[at], one.position[at], one.quaternion[at]).poses()
    seen: Array = np.einsum("nji,nj->ni", some[:, :3, :3], other.position[then] - one.position[at])
    return seen


def _wheel(track: FrameTrack, frame: str) -> list[Shape]:
    r = max(float(track.position[0, 2]), 0.01)
    half = 0.22 * r
    return [
        Tube(frame, (0, -half, 0), (0, half, 0), r, RUBBER),
        Tube(frame, (0, -1.1 * half, 0), (0, 1.1 * half, 0), 0.6 * r, METAL),
        Tube(frame, (0, -1.2 * half, 0.4 * r), (0, 1.2 * half, 0.4 * r), 0.14 * r, AXES[0]),
    ]


def _body(frame: str, wheels: Sequence[FrameTrack], base: FrameTrack) -> list[Shape]:
    """A deck above the wheels, as wide as they stand, with a mark at its front."""
    r = max(float(wheels[0].position[0, 2]), 0.01)
    wide = max(float(np.linalg.norm(_seen(base, wheel)[0, :2])) for wheel in wheels)
    front = np.eye(4)
    front[:3, 3] = 0.6 * wide, 0.0, 2.62 * r
    return [
        Tube(frame, (0, 0, 0.4 * r), (0, 0, 2.2 * r), 0.7 * wide, JOINT),
        Tube(frame, (0, 0, 2.2 * r), (0, 0, 2.6 * r), 1.05 * wide, BODY),
        Box(frame, front, (0.6 * wide, 0.12 * wide, 0.1 * r), AXES[0]),
    ]


def _part(name: str) -> Shape:
    return Disc(name, 0.011, 0.003, PART)


def _axes(frame: str, length: float) -> list[Shape]:
    return [
        Tube(frame, (0, 0, 0), (length * (k == 0), length * (k == 1), length * (k == 2)), 0.06 * length, colour)
        for k, colour in enumerate(AXES)
    ]


def _views(centre: Array, size: float, base: str | None) -> tuple[View, ...]:
    x, y, z = map(float, centre)
    d = 0.4 + 0.8 * size
    beside = (View("Beside it", (-1.0, -1.0, 0.7), (0.0, 0.0, 0.05), follow=base),) if base is not None else ()
    return (
        View("Overview", (x + 0.8 * d, y - 1.1 * d, z + 0.8 * d), (x, y, z)),
        *beside,
        View("From above", (x, y - 0.01, z + 1.8 * d), (x, y, z)),
    )
