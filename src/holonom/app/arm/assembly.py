"""From a cell file's data to the parts of a simulation: arm, plant, world, scene."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from holonom.app.arm.camera import Seen, pixel_axes, placement_pose
from holonom.app.arm.cell_model import ArmCell, Tray, TrayField
from holonom.app.report import Box, Detection, Label, PhotoOverlay, Scene, View, arm_shapes, gripper_shapes
from holonom.app.report import Disc as DiscShape
from holonom.closed_loop import ArmLoop
from holonom.machine import ControlSettings, LineSettings
from holonom.mechanics import Arm, load_arm
from holonom.model import Body
from holonom.sim import Disc, Gripper, Ground, Surface, World
from holonom.spatial import inverse, pose

__all__ = ["build_arm", "build_loop", "build_scene", "build_world", "field_of", "line_settings", "overlay"]

Array = NDArray[np.float64]
WOOD, LEG, TRAY, BRONZE, OTHER = "#d8c3a5", "#8d99ae", "#f1f5f9", "#b08d57", "#94a3b8"


def build_arm(cell: ArmCell) -> Arm:
    """The preset on its base, with the gripper's mass and its tool point between the fingertips."""
    length, mass = cell.gripper.length, cell.gripper.mass
    width = cell.gripper.opening + 2 * cell.gripper.finger[1]
    across = mass * (3 * (width / 2) ** 2 + length**2) / 12
    along = mass * (width / 2) ** 2 / 2
    body = Body(mass, (0.0, 0.0, length / 2), (across, across, along, 0.0, 0.0, 0.0))  # a solid cylinder
    arm = load_arm(cell.arm.preset).with_base(placement_pose(cell.arm.base)).with_load(body)
    arm = arm.with_tool(pose((0.0, 0.0, length)))
    return arm.with_limits(speed=cell.limits.joint_speed, acceleration=cell.limits.joint_acceleration)


def build_loop(cell: ArmCell, arm: Arm, controller: str) -> ArmLoop:
    """The arm with its drives, standing at the cell's home joints above the table."""
    settings = ControlSettings(controller, following_error=cell.limits.following_error)
    return ArmLoop(arm, np.array(cell.arm.home), settings, Ground(height=cell.table.pose.position[2]))


def line_settings(cell: ArmCell) -> LineSettings:
    """What 100 % means on straight lines."""
    limits = cell.limits
    return LineSettings(
        limits.line_speed, limits.line_acceleration, limits.rotation_speed, limits.rotation_acceleration
    )


def build_world(cell: ArmCell, seen: Seen | None) -> tuple[World, Gripper]:
    """Table, tray, gripper and the parts where they truly lie."""
    T_table = placement_pose(cell.table.pose)
    surfaces = [_surface("table", T_table, (0.0, 0.0), cell.table.size, 0.0)]
    if cell.tray is not None:
        surfaces.append(_surface("tray", T_table, cell.tray.corner, cell.tray.size, cell.tray.floor))
    width, thickness, _ = cell.gripper.finger
    speed = cell.gripper.opening / max(cell.gripper.close_time, cell.gripper.open_time)
    return World(surfaces, _discs(cell, seen, T_table)), Gripper(cell.gripper.opening, width, thickness, speed)


def _surface(name: str, T_table: Array, corner: tuple[float, float], size: tuple[float, float], z: float) -> Surface:
    centre = pose((corner[0] + size[0] / 2, corner[1] + size[1] / 2, z))
    return Surface(name, T_table @ centre, size)


def _discs(cell: ArmCell, seen: Seen | None, T_table: Array) -> list[Disc]:
    parts = cell.parts
    if parts is None or seen is None:
        return []
    discs = []
    for number, (centre, diameter) in enumerate(zip(seen.centres, seen.diameters, strict=True), start=1):
        mass = parts.density * parts.thickness * np.pi * (diameter / 2) ** 2
        T = T_table @ pose((*centre, parts.thickness / 2))
        discs.append(Disc(f"{parts.name}_{number:02d}", float(diameter / 2), parts.thickness, float(mass), T))
    return discs


def field_of(cell: ArmCell, disc: Disc) -> str | None:
    """Name of the tray field in which a disc's centre lies, None outside all of them."""
    if cell.tray is None:
        return None
    x, y, z = (inverse(placement_pose(cell.table.pose)) @ disc.pose)[:3, 3]
    for field in cell.tray.fields:
        size = _field_size(field)
        inside = all(0.0 <= v - c <= s for v, c, s in zip((x, y), field.corner, size, strict=True))
        if inside and z < cell.tray.floor + disc.thickness:
            return field.name
    return None


def _field_size(field: TrayField) -> tuple[float, float]:
    return field.columns * field.pitch, field.rows * field.pitch


def group_of(cell: ArmCell, diameter: float) -> str:
    """Name of the field whose size range holds a diameter (m), "other" if none does."""
    for field in cell.tray.fields if cell.tray is not None else ():
        if field.min_diameter <= diameter < field.max_diameter:
            return field.name
    return "other"


def groups(cell: ArmCell) -> Mapping[str, str]:
    """Colour of each group of parts."""
    fields = {field.name: field.colour for field in cell.tray.fields} if cell.tray is not None else {}
    return fields | {"other": OTHER}


def build_scene(cell: ArmCell, seen: Seen | None, world: World) -> Scene:
    """What the report's replay draws."""
    T_table = placement_pose(cell.table.pose)
    shapes = [*arm_shapes(cell.arm.preset), *gripper_shapes(length=cell.gripper.length, finger=_finger(cell))]
    shapes += _table_shapes(cell, T_table)
    if cell.tray is not None:
        shapes += _tray_shapes(cell.tray, T_table)
    for disc in world.discs:
        pixel = None if seen is None else pixel_axes(seen.camera, (inverse(T_table) @ disc.pose)[:2, 3])
        at, axes = pixel if pixel is not None else (None, None)
        shapes.append(DiscShape(disc.name, disc.radius, disc.thickness, BRONZE, at, axes))
    return Scene(tuple(shapes), _views(cell, T_table))


def _finger(cell: ArmCell) -> tuple[float, float, float]:
    width, thickness, length = cell.gripper.finger
    return width, thickness, length


def _table_shapes(cell: ArmCell, T_table: Array) -> list[Box]:
    (width, depth), height, top = cell.table.size, cell.table.pose.position[2], 0.03
    boxes = [Box("world", T_table @ pose((width / 2, depth / 2, -top / 2)), (width, depth, top), WOOD)]
    if height > 2 * top:
        leg = height - top
        for x in (0.03, width - 0.03):
            for y in (0.03, depth - 0.03):
                boxes.append(Box("world", T_table @ pose((x, y, -top - leg / 2)), (0.03, 0.03, leg), LEG))
    return boxes


def _tray_shapes(tray: Tray, T_table: Array) -> list[Box | Label]:
    """Floor, one coloured plate per field and its name; the plates end just below the floor's height."""
    (x, y), (width, depth), floor = tray.corner, tray.size, tray.floor
    thick = max(floor, 1e-3)
    base = T_table @ pose((x + width / 2, y + depth / 2, floor - thick / 2 - 2e-4))
    shapes: list[Box | Label] = [Box("world", base, (width, depth, thick), TRAY)]
    for field in tray.fields:
        w, d = _field_size(field)
        centre = (field.corner[0] + w / 2, field.corner[1] + d / 2)
        shapes.append(Box("world", T_table @ pose((*centre, floor - 5e-5)), (w, d, 1e-4), field.colour))
    return shapes


def _views(cell: ArmCell, T_table: Array) -> tuple[View, ...]:
    width, depth = cell.table.size
    middle = (T_table @ np.array([width / 2, depth / 2, 0.0, 1.0]))[:3]
    x, y, z = (float(v) for v in middle)
    return (
        View("Overview", (x + 0.85, y - 0.95, z + 0.72), (0.58 * x, 0.5 * y, z + 0.2)),
        View("Table", (x + 0.5, y - 0.25, z + 0.55), (x, y, z)),
        View("Side", (0.5 * x, y - 1.7, z + 0.3), (0.5 * x, y, z + 0.15)),
    )


def overlay(cell: ArmCell, seen: Seen, world: World) -> PhotoOverlay:
    """The photograph with what was found in it."""
    assert cell.camera is not None
    detections = tuple(
        Detection(
            d.u, d.v, d.diameter, group_of(cell, p.diameter), p.x, p.y, p.diameter, _frame_at(cell, world, p.x, p.y)
        )
        for d, p in zip(seen.discs, seen.measured, strict=True)
    )
    residual = float(np.max(seen.camera.residual_mm))
    caption = f"{cell.camera.photograph.name}: {len(detections)} parts; calibration residual {residual:.3f} mm at most."
    return PhotoOverlay(seen.png, *seen.size, detections, groups(cell), caption)


def _frame_at(cell: ArmCell, world: World, x: float, y: float) -> str:
    """Frame of the simulated part nearest to a table point; empty when there is none."""
    T = placement_pose(cell.table.pose)
    at = (T @ np.array([x, y, 0.0, 1.0]))[:2]
    near = sorted(world.discs, key=lambda disc: float(np.hypot(*(disc.pose[:2, 3] - at))))
    return near[0].name if near else ""
