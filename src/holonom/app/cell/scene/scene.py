"""`build_scene`: what the replay shows of a cell: shapes in recorded frames, and views that show all of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from holonom import geometry
from holonom.app.cell.build.camera import Seen, pixel_axes
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.places import placement_pose
from holonom.app.cell.model.robot import Robot
from holonom.app.cell.model.world import SurfaceTable, Tray
from holonom.app.cell.scene.arm import shapes_of_arm
from holonom.app.cell.scene.base import patch_shapes, path_shapes, reach_of, shapes_of_base, step_shapes
from holonom.app.cell.scene.views import views_of
from holonom.app.job import ArmJob, BaseJob, Obstacle
from holonom.app.recording.scope import Scope
from holonom.app.report import Box, Scene, Shape, Tube
from holonom.app.report import Disc as DiscShape
from holonom.app.report.attachments import edge_of
from holonom.arrays import Array
from holonom.machine.group import planar_pose
from holonom.model import reach
from holonom.sim import Disc
from holonom.spatial import inverse, pose

__all__ = ["build_scene"]

Sphere = tuple[Array, float]
"""Centre (3,) and radius, m."""
WOOD, LEG, TRAY, BRONZE, FLOOR, WARNING = "#d8c3a5", "#8d99ae", "#f1f5f9", "#b08d57", "#dfe7df", "#e07a5f"


def build_scene(
    cell: Cell,
    arms: Sequence[ArmJob],
    bases: Sequence[BaseJob],
    parts: Sequence[Disc],
    obstacles: Sequence[Obstacle],
    seen: Seen | None,
) -> Scene:
    """What the report's replay draws: robots, what is around them, and views of all of it.

    Frames are called as they are recorded: of a robot with a name `robot/frame`; parts by their names.
    """
    still = _still(cell, parts, obstacles)
    box = _box([*still, *_bases(bases), *_reaches(cell, arms, bases)])
    shapes: list[Shape] = [] if not bases else [_floor(box)]
    shapes += [shape for patch in cell.patch for shape in patch_shapes(patch)]
    shapes += [shape for step in cell.floor.steps for shape in step_shapes(step, edge_of(bases))]
    for base in bases:
        if base.task.path is not None:
            shapes += path_shapes(base.task.path.pose[:: max(1, len(base.task.path.pose) // 120), :2])
        shapes += shapes_of_base(base)
    for robot in cell.robot:
        if robot.is_arm:
            shapes += shapes_of_arm(robot, *_foot(robot, arms, bases))
    for surface in cell.surface:
        shapes += _surface_shapes(surface)
    if cell.tray is not None:
        shapes += _tray_shapes(cell.tray, placement_pose(cell.surface[0].pose))
    shapes += [_obstacle(obstacle) for obstacle in obstacles]
    shapes += [_part(disc, cell, seen) for disc in parts]
    tool, trail = _trail(arms, bases)
    room = float(np.abs(box[:, :2]).max())
    views = views_of(cell, bases, _box([*still, *_bases(bases), *_standing(arms, bases)]))
    return Scene(tuple(shapes), tuple(views), tool=tool, trail=trail, extent=max(1.1, room))


def _foot(robot: Robot, arms: Sequence[ArmJob], bases: Sequence[BaseJob]) -> tuple[str, Array]:
    """Frame in which an arm's own base is drawn, and T (4, 4) of it there."""
    mount = next(arm.mount for arm in arms if arm.name == robot.name)
    if mount is None or mount.robot is None:
        return "world", placement_pose(robot.pose)
    carrier = next(base for base in bases if base.name == mount.robot)
    return Scope(carrier.name, ()).frame("base_link"), carrier.frames[mount.frame] @ mount.T


def _trail(arms: Sequence[ArmJob], bases: Sequence[BaseJob]) -> tuple[str, float]:
    """The frame whose path is drawn, and for how long: an arm's tool, else a base's middle all the way."""
    working = [arm for arm in arms if arm.program is not None] or list(arms)
    if working:
        return Scope(working[0].name, ()).frame("tool"), 2.0
    return Scope(bases[0].name, ()).frame("base_link"), 1e3


def _floor(box: Array) -> Shape:
    middle, size = 0.5 * (box[0] + box[1]), box[1] - box[0]
    return Box("world", pose((middle[0], middle[1], -0.012)), (1.2 * size[0], 1.2 * size[1], 0.02), FLOOR)


def _surface_shapes(surface: SurfaceTable) -> list[Shape]:
    """A plate, on four legs where there is room below it."""
    T, (width, depth), height, top = placement_pose(surface.pose), surface.size, surface.pose.position[2], 0.03
    boxes: list[Shape] = [Box("world", T @ pose((width / 2, depth / 2, -top / 2)), (width, depth, top), WOOD)]
    if height > 2 * top:
        leg, inset = height - top, min(0.03, 0.2 * width, 0.2 * depth)
        for x in (inset, width - inset):
            for y in (inset, depth - inset):
                boxes.append(Box("world", T @ pose((x, y, -top - leg / 2)), (inset, inset, leg), LEG))
    return boxes


def _tray_shapes(tray: Tray, T_table: Array) -> list[Shape]:
    """Floor, one coloured plate per field and its name; the plates end just below the floor's height."""
    (x, y), (width, depth), floor = tray.corner, tray.size, tray.floor
    thick = max(floor, 1e-3)
    base = T_table @ pose((x + width / 2, y + depth / 2, floor - thick / 2 - 2e-4))
    shapes: list[Shape] = [Box("world", base, (width, depth, thick), TRAY)]
    for field in tray.fields:
        w, d = field.size
        centre = (field.corner[0] + w / 2, field.corner[1] + d / 2)
        shapes.append(Box("world", T_table @ pose((*centre, floor - 5e-5)), (w, d, 1e-4), field.colour))
    return shapes


def _obstacle(obstacle: Obstacle) -> Shape:
    shape = obstacle.shape
    if isinstance(shape, geometry.Box):
        return Box("world", obstacle.T, shape.size, WARNING)
    half = 0.5 * shape.height * obstacle.T[:3, 2]
    ends = [tuple((obstacle.T[:3, 3] + sign * half).tolist()) for sign in (-1.0, 1.0)]
    return Tube("world", ends[0], ends[1], shape.radius, WARNING)


def _part(disc: Disc, cell: Cell, seen: Seen | None) -> Shape:
    """A part; one of the photograph wears its own picture."""
    own = cell.parts is not None and disc.name.startswith(f"{cell.parts.name}_")
    own = own and disc.name not in [part.name for part in cell.part]
    if seen is None or not own:
        return DiscShape(disc.name, disc.radius, disc.thickness, BRONZE)
    at, axes = pixel_axes(seen.camera, (inverse(placement_pose(cell.surface[0].pose)) @ disc.pose)[:2, 3])
    return DiscShape(disc.name, disc.radius, disc.thickness, BRONZE, at, axes)


def _still(cell: Cell, parts: Sequence[Disc], obstacles: Sequence[Obstacle]) -> list[Sphere]:
    """Spheres around what stands in a cell."""
    spheres: list[Sphere] = []
    for surface in cell.surface:
        T = placement_pose(surface.pose)
        spheres += [((T @ pose((x, y, 0.0)))[:3, 3], 0.02) for x in (0, surface.size[0]) for y in (0, surface.size[1])]
    for patch in cell.patch:
        half = patch.radius if patch.radius is not None else 0.5 * max(patch.size or (0.0,))
        spheres.append((np.array([*patch.centre, 0.0]), half))
    spheres += [(disc.pose[:3, 3], disc.radius) for disc in parts]
    for o in obstacles:
        corners = geometry.outline(o.shape) @ o.T[:2, :2].T + o.T[:2, 3]
        spheres += [(np.array([*corner, o.T[2, 3] + 0.5 * o.shape.height]), 0.02) for corner in corners]
    return spheres


def _bases(bases: Sequence[BaseJob]) -> list[Sphere]:
    """Spheres around bases wherever they go."""
    return [(way[:3, 3], reach_of(base.base)) for base in bases for way in _ways(base)]


def _reaches(cell: Cell, arms: Sequence[ArmJob], bases: Sequence[BaseJob]) -> list[Sphere]:
    """Spheres around where arms may work."""
    spheres: list[Sphere] = []
    for robot, arm in zip([robot for robot in cell.robot if robot.is_arm], arms, strict=True):
        _, T = _foot(robot, arms, bases)
        far = 0.7 * reach(robot.source.model)
        spheres += [((way @ T)[:3, 3] + [0.0, 0.0, 0.3 * far], far) for way in _carried(arm, bases)]
    return spheres


def _standing(arms: Sequence[ArmJob], bases: Sequence[BaseJob]) -> list[Sphere]:
    """Spheres around arms as they stand at first, wherever they are carried."""
    spheres: list[Sphere] = []
    for arm in arms:
        frames = arm.arm.frames(arm.home)
        thick = 0.08 * reach(arm.arm.model)
        if arm.mount is not None:
            carrier = next((base for base in bases if base.name == arm.mount.robot), None)
            frames = (arm.mount.T if carrier is None else carrier.frames[arm.mount.frame] @ arm.mount.T) @ frames
        spheres += [((way @ T)[:3, 3], thick) for way in _carried(arm, bases) for T in frames]
    return spheres


def _carried(arm: ArmJob, bases: Sequence[BaseJob]) -> list[Array]:
    """T (4, 4) of what carries an arm, wherever it goes."""
    if arm.mount is None or arm.mount.robot is None:
        return [np.eye(4)]
    return _ways(next(base for base in bases if base.name == arm.mount.robot))


def _box(spheres: Iterable[Sphere]) -> Array:
    """Corners (2, 3) of a box around spheres, m."""
    low = np.min([np.asarray(p) - r for p, r in spheres], axis=0)
    high = np.max([np.asarray(p) + r for p, r in spheres], axis=0)
    low[2], high[2] = max(low[2], 0.0) if low[2] > -0.3 else low[2], max(high[2], 0.2)
    return np.stack([low, high])


def _ways(base: BaseJob) -> list[Array]:
    """T (4, 4) of base_link where a base may come: along its path, or by its velocities."""
    found = [planar_pose(base.pose)]
    if base.task.path is not None:
        path = base.task.path.pose
        return [planar_pose(row) for row in path[:: max(1, len(path) // 60)]] + [planar_pose(path[-1])]
    if base.task.velocities is not None:
        rows = base.task.velocities
        for row, until in zip(rows, [*rows[1:, 0], rows[-1, 0] + 1.0], strict=True):
            steps = max(1, min(400, round((until - row[0]) / 0.05)))
            dt = (until - row[0]) / steps
            move = planar_pose(dt * row[1:])
            for _ in range(steps):
                found.append(found[-1] @ move)
    return found
