"""Discs of an image as parts on the table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import CalibrationError
from holonom.spatial import check_pose
from holonom.vision.coins import Disc
from holonom.vision.homography import TableCamera, to_table
from holonom.vision.outline import polygon_moments

__all__ = ["TablePart", "in_robot_frame", "measure"]


@dataclass(frozen=True, slots=True)
class TablePart:
    """A round thing on the table.

    Centroid `x`, `y` (m, table frame), `area` (m2), `diameter` (m) of the circle of equal area.
    """

    x: float
    y: float
    area: float
    diameter: float


def measure(camera: TableCamera, discs: Iterable[Disc]) -> tuple[TablePart, ...]:
    """Place and size of discs on the table, in their order.

    The outline is mapped and measured on the table, so that perspective changes neither centre nor size.

    Raises
    ------
    CalibrationError
        If a disc reaches the horizon of the camera.
    """
    return tuple(_measured(camera, disc) for disc in discs)


def in_robot_frame(parts: Iterable[TablePart], T_wt: ArrayLike) -> NDArray[np.float64]:
    """Centres (k, 3) in the world frame, metres, of parts on the table top.

    Parameters
    ----------
    parts
        Parts in the table frame, whose plane z = 0 is the table top.
    T_wt
        Pose of the table frame in the world, (4, 4).

    Raises
    ------
    NotAPose
        If `T_wt` is no rigid transform.
    """
    pose = check_pose(T_wt, "T_wt")
    centres = np.array([[part.x, part.y] for part in parts], dtype=np.float64).reshape(-1, 2)
    return centres @ pose[:3, :2].T + pose[:3, 3]


def _measured(camera: TableCamera, disc: Disc) -> TablePart:
    outline = to_table(camera, disc.contour)
    if np.isnan(outline).any():
        raise CalibrationError(f"the disc at pixel {disc.u:.0f}, {disc.v:.0f} reaches the horizon of the camera")
    area, centre, _ = polygon_moments(outline[None])
    return TablePart(float(centre[0, 0]), float(centre[0, 1]), float(area[0]), float(2.0 * np.sqrt(area[0] / np.pi)))
