"""What the cell's camera sees: from the photograph to parts that a program can ask for."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from holonom.app.arm.cell_model import ArmCell, Camera, Parts
from holonom.app.cell_tables import Placement
from holonom.app.toml_lines import place_of
from holonom.errors import CalibrationError, CellError, ImageError
from holonom.lang import Part
from holonom.spatial import pose
from holonom.vision import (
    Disc,
    TableCamera,
    TablePart,
    find_coins,
    fit_homography,
    grasp_angles,
    load_photograph,
    measure,
    to_pixel,
    to_table,
)

__all__ = ["Seen", "calibrate", "look", "pixel_axes", "placement_pose"]

Array = NDArray[np.float64]
FINGER_CLEARANCE = 1.5e-3
"""Room (m) wanted between an open finger and a neighbouring part."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A photograph, its calibration and what was found: discs in pixels, parts on the table, parts for the program.

    `centres` (k, 2) and `diameters` (k,), in m, say where the simulated parts truly lie in the table frame, in the
    order in which the camera numbers them, as far as it sees them.
    """

    camera: TableCamera
    discs: tuple[Disc, ...]
    measured: tuple[TablePart, ...]
    parts: tuple[Part, ...]
    centres: Array
    diameters: Array
    png: bytes
    """the photograph as a PNG file"""
    size: tuple[int, int]
    """its width and height, px"""


def placement_pose(placement: Placement) -> Array:
    """T_w(placement), 4x4."""
    return pose(placement.position, Rotation.from_euler("z", placement.angle).as_matrix())


def look(cell: ArmCell, path: Path) -> Seen:
    """Find the parts in the cell's photograph.

    Raises
    ------
    CellError
        The calibration points do not determine the camera, or the layout is none; names the file.
    ImageError
        The photograph is missing or not an image.
    """
    assert cell.camera is not None
    assert cell.parts is not None
    try:
        image = load_photograph(cell.camera.photograph)
    except ImageError as problem:
        raise ImageError(f"{place_of(path, 'camera', 'photograph')}: {problem}") from problem
    camera = calibrate(cell.camera, path)
    discs = find_coins(image)
    measured = measure(camera, discs)
    parts = _for_program(cell, cell.parts, measured)
    centres = np.array([[part.x, part.y] for part in measured]).reshape(-1, 2)
    diameters = np.array([part.diameter for part in measured])
    if cell.parts.layout is not None:
        centres, diameters = _layout(_read_layout(cell.parts.layout), camera, discs)
    png = cv2.imencode(".png", image)[1].tobytes()
    return Seen(camera, discs, measured, parts, centres, diameters, png, (image.shape[1], image.shape[0]))


def calibrate(camera: Camera, path: Path) -> TableCamera:
    """Fit the camera to the cell's calibration points."""
    pixels = np.array([point.pixel for point in camera.points], dtype=float)
    table = np.array([point.table for point in camera.points], dtype=float)
    try:
        return fit_homography(pixels, table)
    except CalibrationError as problem:
        raise CellError(f"{place_of(path, 'camera', 'points')}: {problem}") from problem


def _for_program(cell: ArmCell, parts: Parts, measured: tuple[TablePart, ...]) -> tuple[Part, ...]:
    """Tool poses that grasp the parts (tool z down, fingers closing along tool y) and their features."""
    T_w_table = placement_pose(cell.table.pose)
    centres = np.array([[part.x, part.y] for part in measured]).reshape(-1, 2)
    angles = grasp_angles(
        centres,
        np.array([part.diameter for part in measured]),
        opening=cell.gripper.opening,
        finger=cell.gripper.finger[:2],
        preferred=np.pi / 2,
        clearance=FINGER_CLEARANCE,
    )
    found = []
    for part, angle in zip(measured, angles, strict=True):
        turn = Rotation.from_euler("z", angle - np.pi / 2) * Rotation.from_euler("ZYZ", [0.0, np.pi, 0.0])
        T = T_w_table @ pose((part.x, part.y, parts.grasp_height), turn.as_matrix())
        x, y = T[0, 3], T[1, 3]
        found.append(Part(parts.name, T, (1.0, float(x), float(y), float(angle), part.area, part.diameter)))
    return tuple(found)


def _layout(rows: Array, camera: TableCamera, discs: tuple[Disc, ...]) -> tuple[Array, Array]:
    """Centres (k, 2) and diameters (k,) on the table (m) of rows u, v, diameter (px), in the order of the discs."""
    centres = to_table(camera, rows[:, :2])
    step = to_table(camera, rows[:, :2] + np.array([1.0, 0.0])) - centres
    found = np.array([[disc.u, disc.v] for disc in discs]).reshape(-1, 2)
    apart = np.linalg.norm(rows[:, None, :2] - found[None], axis=-1)
    number = apart.argmin(axis=1) if len(found) else np.zeros(len(rows))
    order = np.argsort(number, kind="stable")
    return centres[order], (rows[:, 2] * np.hypot(step[:, 0], step[:, 1]))[order]


def _read_layout(path: Path) -> Array:
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        try:
            rows = [[float(row[key]) for key in ("u", "v", "diameter")] for row in reader]
        except (KeyError, TypeError, ValueError, UnicodeDecodeError) as problem:
            raise CellError(
                f"{path}:{reader.line_num}: {problem} is missing or no number; a layout has the columns u,v,diameter"
            ) from None
    found = np.array(rows).reshape(-1, 3)
    if not np.isfinite(found).all() or (found[:, 2] <= 0.0).any():
        raise CellError(f"{path}: u and v must be finite and diameters positive")
    return found


def pixel_axes(camera: TableCamera, centre: Array) -> tuple[Array, Array]:
    """Pixel of a table point (2,) and pixels per metre along the table's x and y there, (2, 2)."""
    h = 1e-4
    points = centre + np.array([[0.0, 0.0], [h, 0.0], [0.0, h]])
    uv = to_pixel(camera, points)
    return uv[0], ((uv[1:] - uv[0]) / h).T
