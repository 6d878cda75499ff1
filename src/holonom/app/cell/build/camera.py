"""What the cell's camera sees: from the photograph to parts that a program can ask for, and to simulated ones."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from holonom.app.cell.load import place_in
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.places import placement_pose
from holonom.app.cell.model.robot import GripperTool
from holonom.app.cell.model.world import Camera
from holonom.app.report import Detection, PhotoOverlay
from holonom.arrays import Array
from holonom.errors import CalibrationError, CellError, ImageError
from holonom.files import check_lines, decimal, read_text
from holonom.lang import Part
from holonom.sim import Disc as SimulatedDisc
from holonom.spatial import pose

if TYPE_CHECKING:
    from holonom.vision import Disc, TableCamera, TablePart

__all__ = ["OTHER", "Seen", "calibrate", "look", "overlay", "parts_for", "pixel_axes", "simulated_parts"]

FINGER_CLEARANCE = 1.5e-3
"""Room (m) wanted between an open finger and a neighbouring part."""
SMALLEST, LARGEST, FARTHEST = 1e-4, 1.0, 100.0
"""Diameters of parts, and how far from the surface's corner they may lie, m."""
PIXELS = 1e5
"""Beyond any photograph."""
ROWS = 10_000
"""Parts of a layout."""
OTHER = "#94a3b8"
"""Colour of parts that belong to no field."""


@dataclass(frozen=True, slots=True)
class Seen:
    """A photograph, its calibration and what was found: discs in pixels, parts on the surface.

    `centres` (k, 2) and `diameters` (k,), in m, say where the simulated parts truly lie in the surface's frame, in the
    order in which the camera numbers them, as far as it sees them.
    """

    camera: TableCamera
    discs: tuple[Disc, ...]
    measured: tuple[TablePart, ...]
    centres: Array
    diameters: Array
    png: bytes
    """the photograph as a PNG file"""
    size: tuple[int, int]
    """its width and height, px"""


def look(cell: Cell, path: Path) -> Seen | None:
    """Find the parts in the cell's photograph; None without a camera.

    Raises
    ------
    CellError
        The calibration points do not determine the camera, or the layout is none; names the file.
    ImageError
        The photograph is missing or not an image.
    MissingExtra
        OpenCV is not installed.
    """
    if cell.camera is None or cell.parts is None:
        return None
    from holonom import vision

    try:
        image = vision.load_photograph(cell.camera.photograph)
    except ImageError as problem:
        raise ImageError(f"{place_in(path, 'camera', 'photograph')}: {problem}") from problem
    camera = calibrate(cell.camera, path)
    discs = vision.find_coins(image)
    measured = vision.measure(camera, discs)
    centres = np.array([[part.x, part.y] for part in measured]).reshape(-1, 2)
    diameters = np.array([part.diameter for part in measured])
    _refuse_huge(centres, diameters, f"{place_in(path, 'camera', 'points')}: by these points")
    if cell.parts.layout is not None:
        centres, diameters = _layout(_read_layout(cell.parts.layout), camera, discs)
        _refuse_huge(centres, diameters, str(cell.parts.layout))
    from holonom.vision.opencv import cv2

    png = cv2.imencode(".png", image)[1].tobytes()
    return Seen(camera, discs, measured, centres, diameters, png, (image.shape[1], image.shape[0]))


def _refuse_huge(centres: Array, diameters: Array, place: str) -> None:
    """Raise `CellError` at a part that is no part of any cell."""
    wrong = ~((diameters > SMALLEST) & (diameters < LARGEST) & (np.abs(centres) < FARTHEST).all(axis=1))
    if wrong.any():
        k = int(np.flatnonzero(wrong)[0])
        x, y = centres[k]
        raise CellError(
            f"{place}: part {k + 1} has a diameter of {diameters[k]:.3g} m and lies at {x:.3g}, {y:.3g} m; parts of "
            f"{1e3 * SMALLEST:g} mm to {LARGEST:g} m within {FARTHEST:g} m are allowed"
        )


def calibrate(camera: Camera, path: Path) -> TableCamera:
    """Fit the camera to the cell's calibration points."""
    from holonom import vision

    pixels = np.array([point.pixel for point in camera.points], dtype=float)
    table = np.array([point.table for point in camera.points], dtype=float)
    try:
        return vision.fit_homography(pixels, table)
    except CalibrationError as problem:
        raise CellError(f"{place_in(path, 'camera', 'points')}: {problem}") from problem


def parts_for(hand: GripperTool, cell: Cell, seen: Seen) -> tuple[Part, ...]:
    """Tool poses in the world with which a hand grasps the parts (z down, fingers closing along y), and features."""
    from holonom import vision

    assert cell.parts is not None
    T_w_table = placement_pose(cell.surface[0].pose)
    centres = np.array([[part.x, part.y] for part in seen.measured]).reshape(-1, 2)
    angles = vision.grasp_angles(
        centres,
        np.array([part.diameter for part in seen.measured]),
        opening=hand.opening,
        finger=hand.finger[:2],
        preferred=np.pi / 2,
        clearance=FINGER_CLEARANCE,
    )
    found = []
    for part, angle in zip(seen.measured, angles, strict=True):
        turn = Rotation.from_euler("z", angle - np.pi / 2) * Rotation.from_euler("ZYZ", [0.0, np.pi, 0.0])
        T = T_w_table @ pose((part.x, part.y, cell.parts.grasp_height), turn.as_matrix())
        x, y = T[0, 3], T[1, 3]
        found.append(Part(cell.parts.name, T, (1.0, float(x), float(y), float(angle), part.area, part.diameter)))
    return tuple(found)


def simulated_parts(cell: Cell, seen: Seen | None) -> list[SimulatedDisc]:
    """The parts where they truly lie: those of the photograph, then those of [[part]]."""
    found = _photographed(cell, seen)
    for part in cell.part:
        T = placement_pose(part.pose) @ pose((0.0, 0.0, part.thickness / 2))
        found.append(SimulatedDisc(part.name, part.radius, part.thickness, part.mass, T))
    return found


def _photographed(cell: Cell, seen: Seen | None) -> list[SimulatedDisc]:
    parts = cell.parts
    if parts is None or seen is None:
        return []
    discs, T_table = [], placement_pose(cell.surface[0].pose)
    for number, (centre, diameter) in enumerate(zip(seen.centres, seen.diameters, strict=True), start=1):
        mass = parts.density * parts.thickness * np.pi * (diameter / 2) ** 2
        T = T_table @ pose((*centre, parts.thickness / 2))
        discs.append(SimulatedDisc(f"{parts.name}_{number:02d}", float(diameter / 2), parts.thickness, float(mass), T))
    return discs


def _layout(rows: Array, camera: TableCamera, discs: tuple[Disc, ...]) -> tuple[Array, Array]:
    """Centres (k, 2) and diameters (k,) on the surface (m) of rows u, v, diameter (px), in the order of the discs."""
    from holonom import vision

    centres = vision.to_table(camera, rows[:, :2])
    step = vision.to_table(camera, rows[:, :2] + np.array([1.0, 0.0])) - centres
    found = np.array([[disc.u, disc.v] for disc in discs]).reshape(-1, 2)
    apart = np.linalg.norm(rows[:, None, :2] - found[None], axis=-1)
    number = apart.argmin(axis=1) if len(found) else np.zeros(len(rows))
    order = np.argsort(number, kind="stable")
    return centres[order], (rows[:, 2] * np.hypot(step[:, 0], step[:, 1]))[order]


def _read_layout(path: Path) -> Array:
    """Rows (k, 3) of u, v and diameter, px."""
    text = read_text(path, "layout", CellError)
    check_lines(text, path, CellError, most=ROWS)
    reader = csv.DictReader(text.split("\n"), strict=True)
    try:
        rows = [[decimal(row[key]) for key in ("u", "v", "diameter")] for row in reader]
    except (KeyError, TypeError, ValueError, csv.Error):
        raise CellError(
            f"{path}:{max(1, reader.line_num)}: a value is missing or no number; a layout has the columns u,v,diameter"
        ) from None
    found = np.array(rows).reshape(-1, 3)
    wrong = ~(np.isfinite(found).all(axis=1) & (np.abs(found) < PIXELS).all(axis=1) & (found[:, 2] > 0.0))
    if wrong.any():
        raise CellError(
            f"{path}: part {int(np.flatnonzero(wrong)[0]) + 1}: u and v must be finite and diameters positive, all "
            f"below {PIXELS:g} px"
        )
    return found


def pixel_axes(camera: TableCamera, centre: Array) -> tuple[Array, Array]:
    """Pixel of a surface point (2,) and pixels per metre along the surface's x and y there, (2, 2)."""
    from holonom import vision

    h = 1e-4
    points = centre + np.array([[0.0, 0.0], [h, 0.0], [0.0, h]])
    uv = vision.to_pixel(camera, points)
    return uv[0], ((uv[1:] - uv[0]) / h).T


def overlay(cell: Cell, seen: Seen, parts: tuple[SimulatedDisc, ...]) -> PhotoOverlay:
    """The photograph with what was found in it."""
    assert cell.camera is not None
    detections = tuple(
        Detection(
            d.u, d.v, d.diameter, _group_of(cell, p.diameter), p.x, p.y, p.diameter, _frame_at(cell, parts, p.x, p.y)
        )
        for d, p in zip(seen.discs, seen.measured, strict=True)
    )
    residual = float(np.max(seen.camera.residual_mm))
    caption = f"{cell.camera.photograph.name}: {len(detections)} parts; calibration residual {residual:.3f} mm at most."
    fields = cell.tray.fields if cell.tray is not None else ()
    groups = {field.name: field.colour for field in fields} | {"other": OTHER}
    return PhotoOverlay(seen.png, *seen.size, detections, groups, caption)


def _group_of(cell: Cell, diameter: float) -> str:
    """Name of the field whose size range holds a diameter (m), "other" if none does."""
    for field in cell.tray.fields if cell.tray is not None else ():
        if field.min_diameter <= diameter < field.max_diameter:
            return field.name
    return "other"


def _frame_at(cell: Cell, parts: tuple[SimulatedDisc, ...], x: float, y: float) -> str:
    """Frame of the simulated part nearest to a surface point; empty when there is none."""
    at = (placement_pose(cell.surface[0].pose) @ np.array([x, y, 0.0, 1.0]))[:2]
    near = sorted(parts, key=lambda disc: float(np.hypot(*(disc.pose[:2, 3] - at))))
    return near[0].name if near else ""
