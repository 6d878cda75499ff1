"""Where the report's replay looks from at first: everything, each surface, beside each base, from above."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.places import placement_pose
from holonom.app.job import BaseJob
from holonom.app.recording.scope import Scope
from holonom.app.report import View
from holonom.arrays import Array

__all__ = ["views_of"]

HALF_HEIGHT = math.tan(math.radians(0.5 * 38.0))
"""Of the replay's picture at a distance of 1."""
HALF_WIDTH = 1.5 * HALF_HEIGHT
MARGIN = 1.05


def views_of(cell: Cell, bases: Sequence[BaseJob], box: Array) -> Iterable[View]:
    """Return views of a cell; `box` (2, 3), m, are corners of a box around what is to be seen of it."""
    yield _fitted("Overview", box, (0.55, -0.7, 0.5))
    for number, surface in enumerate(cell.surface):
        width, depth = surface.size
        x, y, z, _ = (float(v) for v in placement_pose(surface.pose) @ np.array([width / 2, depth / 2, 0.0, 1.0]))
        name = "Table" if number == 0 and surface.name == "table" else surface.name
        yield View(name, (x + 0.5, y - 0.25, z + 0.55), (x, y, z))
    for base in bases:
        r = base.base.radius
        frame = Scope(base.name, ()).frame("base_link")
        name = f"Beside {base.name}" if base.name else "Beside it"
        yield View(name, (-5.0 * r, -5.0 * r, 3.5 * r), (0.0, 0.0, 0.3 * r), follow=frame)
    yield _fitted("Side", box, (0.0, -1.0, 0.1))
    if bases:
        yield _fitted("From above", box, (0.0, -0.01, 1.0))


def _fitted(name: str, box: Array, direction: tuple[float, float, float]) -> View:
    """View of a box from a direction, as near as all of it is in the picture."""
    back = np.array(direction) / np.linalg.norm(direction)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    middle = box.mean(axis=0)
    corners = np.array([[x, y, z] for x in box[:, 0] for y in box[:, 1] for z in box[:, 2]]) - middle
    wide, high = np.abs(corners @ right) / HALF_WIDTH, np.abs(corners @ np.cross(back, right)) / HALF_HEIGHT
    away = float((MARGIN * np.maximum(wide, high) + corners @ back).max())
    eye = middle + away * back
    return View(
        name, (float(eye[0]), float(eye[1]), float(eye[2])), (float(middle[0]), float(middle[1]), float(middle[2]))
    )
