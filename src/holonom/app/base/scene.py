"""What the replay of a base shows: body, wheels that turn, floor, patches and the path to drive."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from holonom.app.base.cell_model import BaseCell, Patch
from holonom.app.report import Box, Label, Scene, Shape, Tube, View
from holonom.app.wheel_frames import wheel_frames, wheel_poses
from holonom.mobile import Wheel, WheelBase
from holonom.spatial import pose

__all__ = ["build_scene", "patch_corners", "wheel_frames", "wheel_poses"]

Array = NDArray[np.float64]
BODY, DECK, RUBBER, METAL, MARK, FLOOR = "#33415c", "#eef1f5", "#1f2937", "#aab4c3", "#d9480f", "#dfe7df"
WHEEL_WIDTH = 0.45
"""Width of a drawn wheel over its radius."""


def build_scene(cell: BaseCell, base: WheelBase, path: Array) -> Scene:
    """Shapes in the frames "world", "base_link" and those of `wheel_frames`; `path` (N, 2) is dotted on the floor."""
    extent = float(np.abs(path).max()) + 3.0 * base.radius
    shapes: list[Shape] = [Box("world", pose((0.0, 0.0, -0.012)), (2.4 * extent, 2.0 * extent, 0.02), FLOOR)]
    shapes += [shape for patch in cell.floor.patches for shape in _patch_shapes(patch)]
    shapes += [
        Tube("world", (x, y, -0.0015), (x, y, -0.0005), 0.006, "#7c8b9d") for x, y in path[:: max(1, len(path) // 120)]
    ]
    shapes += _body(base)
    for frame, wheel in zip(wheel_frames(base), _driven(base), strict=True):
        shapes += _wheel(frame, wheel)
    return Scene(tuple(shapes), _views(extent, base.radius), tool="base_link", trail=1e3, extent=extent)


def patch_corners(patch: Patch) -> Array:
    """Corners (N, 2) of a patch in the world; of a round one, of a polygon."""
    if patch.radius is not None:
        turn = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
        return np.array(patch.centre) + patch.radius * np.stack([np.cos(turn), np.sin(turn)], -1)
    assert patch.size is not None
    half = 0.5 * np.array(patch.size) * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    c, s = math.cos(patch.angle), math.sin(patch.angle)
    return np.array(patch.centre) + half @ np.array([[c, s], [-s, c]])


def _driven(base: WheelBase) -> list[Wheel]:
    return [wheel for wheel in base.wheels if wheel.driven]


def _body(base: WheelBase) -> list[Shape]:
    """A drum above and between the wheels, with a mark at its front."""
    r = base.wheels[0].radius
    rim = max(math.hypot(wheel.x, wheel.y) for wheel in base.wheels)
    low, high = 0.35 * r, 2.2 * r
    return [
        Tube("base_link", (0, 0, low), (0, 0, high), 0.72 * rim, BODY),
        Tube("base_link", (0, 0, 2.1 * r), (0, 0, 2.45 * r), 1.12 * rim, BODY),
        Tube("base_link", (0, 0, 2.45 * r), (0, 0, 2.6 * r), 1.06 * rim, DECK),
        Box("base_link", pose((0.62 * rim, 0.0, 2.64 * r)), (0.62 * rim, 0.12 * rim, 0.1 * r), MARK),
    ]


def _wheel(frame: str, wheel: Wheel) -> list[Shape]:
    """A wheel about the y axis of its frame, with a hub and a mark on both faces that shows its turning."""
    r, half = wheel.radius, 0.5 * WHEEL_WIDTH * wheel.radius
    face = half + 0.03 * r
    return [
        Tube(frame, (0, -half, 0), (0, half, 0), r, RUBBER),
        Tube(frame, (0, -face, 0), (0, face, 0), 0.62 * r, METAL),
        Tube(frame, (0, -face - 0.02 * r, 0.4 * r), (0, face + 0.02 * r, 0.4 * r), 0.14 * r, MARK),
    ]


def _patch_shapes(patch: Patch) -> list[Shape]:
    x, y = patch.centre
    top = -0.0012
    label = Label("world", pose((x, y, top + 6e-4)), patch.name, 0.06, "#3b6d8f")
    if patch.radius is not None:
        return [Tube("world", (x, y, -0.006), (x, y, top), patch.radius, "#bfe3f5"), label]
    assert patch.size is not None
    T = pose((x, y, top - 0.003))
    T[:3, :3] = Rotation.from_euler("z", patch.angle).as_matrix()
    return [Box("world", T, (*patch.size, 0.006), "#bfe3f5"), label]


def _views(extent: float, radius: float) -> tuple[View, ...]:
    e, r = extent, radius
    return (
        View("Overview", (0.05 * e, -1.7 * e, 1.15 * e), (0.0, -0.12 * e, 0.0)),
        View("Beside it", (-5.0 * r, -5.0 * r, 3.5 * r), (0.0, 0.0, 0.3 * r), follow="base_link"),
        View("From above", (0.0, -0.01, 2.6 * e), (0.0, 0.0, 0.0)),
    )
