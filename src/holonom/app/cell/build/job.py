"""`build_job`: from what a cell file says to the domain objects of a run. Nothing is written."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from holonom.app.cell.build.arm import ArmBuild, build_arm_job
from holonom.app.cell.build.base import build_base_job, refuse_unsimulated
from holonom.app.cell.build.camera import Seen, look, overlay, simulated_parts
from holonom.app.cell.load import place_in
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.places import placement_pose
from holonom.app.cell.model.robot import Robot
from holonom.app.cell.model.sensor import Sensor
from holonom.app.cell.model.world import Patch
from holonom.app.cell.never import refuse_never, too_late
from holonom.app.cell.scene.scene import build_scene
from holonom.app.job import ArmJob, BaseJob, FieldPlace, Job, Mount, Obstacle, SensorJob, SignalEvent
from holonom.arrays import Array
from holonom.devices import Accelerometer, CurrentShunt, Gyro
from holonom.errors import CellError
from holonom.geometry import Box, Cylinder
from holonom.mobile import BaseSensors
from holonom.sim import SENSORS, Disc, Floor, Material, RectangularPatch, RoundPatch, Step, Surface
from holonom.spatial import pose

__all__ = ["build_job", "refuse_unsimulated"]

OF_BASES = {
    Gyro: {"noise": "gyro_noise", "bias": "gyro_bias"},
    Accelerometer: {"noise": "accelerometer_noise", "bias": "accelerometer_bias"},
    CurrentShunt: {"noise": "current_noise"},
}
"""Data sheets of the sensors that a base's controller reads, and which of its fields are which of `BaseSensors`."""


def build_job(cell: Cell, path: Path) -> Job:
    """Build all that the cell, the file `path`, describes.

    Raises
    ------
    CellError
        What does not go together; names file, line and key.
    ImageError
        The photograph is missing or not an image.
    ProgramError
        A program or its location file.
    """
    seen = look(cell, path)
    bases, notes = _bases(cell, path)
    arms = _arms(cell, path, seen, {base.name: base for base in bases})
    parts = tuple(simulated_parts(cell, seen))
    job_arms = tuple(arm.job for arm in arms)
    refuse_never(cell, path, job_arms, bases)
    obstacles = tuple(
        Obstacle(o.name, placement_pose(o.pose), Box(o.size) if o.size else Cylinder(o.radius or 0.0, o.height or 0.0))
        for o in cell.obstacle
    )
    return Job(
        name=cell.cell.name,
        description=cell.cell.description,
        file=path,
        seed=cell.cell.seed,
        time_limit=cell.cell.time_limit,
        arms=job_arms,
        bases=bases,
        floor=_floor(cell),
        surfaces=tuple(_surfaces(cell)),
        parts=parts,
        obstacles=obstacles,
        sensors=_sensors(cell, path),
        events=tuple(SignalEvent(event.at, event.signal, event.on) for event in cell.event if event.signal),
        patches=tuple(patch.name for patch in cell.patch),
        fields=_fields(cell, parts),
        scene=build_scene(cell, job_arms, bases, parts, obstacles, seen),
        photograph=overlay(cell, seen, parts) if seen is not None else None,
        notes=(*notes, *(note for arm in arms for note in arm.notes), *_not_compared(job_arms), *too_late(cell)),
        unreachable=tuple(line for arm in arms for line in arm.unreachable),
    )


def _not_compared(arms: tuple[ArmJob, ...]) -> Iterator[str]:
    """Say that controllers are not compared where several arms move."""
    for arm in arms:
        if len(arms) > 1 and len(arm.settings) > 1:
            yield (
                f"{arm.name}: it runs under {arm.settings[-1].controller.replace('_', ' ')} only; controllers are "
                "compared in cells of one arm"
            )


def _bases(cell: Cell, path: Path) -> tuple[tuple[BaseJob, ...], tuple[str, ...]]:
    jobs: list[BaseJob] = []
    notes: list[str] = []
    for number, robot in enumerate(cell.robot):
        if not robot.is_arm:
            job, remarks = build_base_job(cell, number, path, _base_sensors(cell, robot))
            jobs.append(job)
            notes += remarks
    return tuple(jobs), tuple(notes)


def _arms(cell: Cell, path: Path, seen: Seen | None, bases: dict[str, BaseJob]) -> tuple[ArmBuild, ...]:
    found = []
    for number, robot in enumerate(cell.robot):
        if robot.is_arm:
            mount, height = _mount(robot), 0.0
            if mount is not None and mount.robot is not None:
                height = float((bases[mount.robot].frames[mount.frame] @ mount.T)[2, 3])
            found.append(build_arm_job(cell, number, path, seen, mount, height))
    return tuple(found)


def _mount(robot: Robot) -> Mount | None:
    """On which robot it stands; by its top unless a frame is named."""
    if robot.on is None:
        return None
    carrier, _, frame = robot.on.partition(".")
    return Mount(placement_pose(robot.pose), carrier, frame or "top")


def _base_sensors(cell: Cell, robot: Robot) -> BaseSensors:
    """The inertial sensors and shunts of a base: what the cell says, else good ones."""
    found = {}
    for sensor in cell.sensor:
        if cell.robot_of(sensor.robot) is robot:
            for key, name in OF_BASES.get(type(sensor.method.params), {}).items():
                found[name] = getattr(sensor.method.params, key)
    return BaseSensors(**found)


def _sensors(cell: Cell, path: Path) -> tuple[SensorJob, ...]:
    """Sensors that the run itself reads."""
    found = []
    for number, sensor in enumerate(cell.sensor):
        robot = cell.robot_of(sensor.robot)
        if type(sensor.method.params) in OF_BASES and not robot.is_arm:
            continue
        made = sensor.method.make()
        if not hasattr(made, "read"):
            raise CellError(f"{place_in(path, 'sensor', number, 'kind')}: {_why_not(sensor, robot)}")
        found.append(SensorJob(sensor.name, robot.name, sensor.method.name, made))
    return tuple(found)


def _why_not(sensor: Sensor, robot: Robot) -> str:
    what = "an arm" if robot.is_arm else "a base"
    return (
        f"{sensor.method.name!r} cannot be read on {what}: what its table makes has no read(truth, rng); "
        f"a base takes {', '.join(name for name in SENSORS if SENSORS[name].record in OF_BASES)}; encoders are stated "
        "in drives"
    )


def _floor(cell: Cell) -> Floor:
    floor = cell.floor
    material = Material(floor.friction, floor.sliding_friction, floor.slip_at_peak)
    patches = tuple(_patch(patch, floor.slip_at_peak) for patch in cell.patch)
    steps = tuple(Step(step.position, step.height, step.rise) for step in floor.steps)
    return Floor(material, patches, floor.slope, floor.uphill, steps)


def _patch(patch: Patch, slip_at_peak: float) -> RoundPatch | RectangularPatch:
    material = Material(patch.friction, patch.sliding_friction, slip_at_peak)
    if patch.radius is not None:
        return RoundPatch(patch.centre, patch.radius, material)
    assert patch.size is not None
    return RectangularPatch(patch.centre, *patch.size, material, patch.angle)


def _surfaces(cell: Cell) -> list[Surface]:
    """The surfaces, the tray behind the one that it stands on."""
    found = [_surface(s.name, placement_pose(s.pose), (0.0, 0.0), s.size, 0.0) for s in cell.surface]
    if cell.tray is not None:
        T = placement_pose(cell.surface[0].pose)
        found.insert(1, _surface("tray", T, cell.tray.corner, cell.tray.size, cell.tray.floor))
    return found


def _surface(name: str, T: Array, corner: tuple[float, float], size: tuple[float, float], z: float) -> Surface:
    centre = pose((corner[0] + size[0] / 2, corner[1] + size[1] / 2, z))
    return Surface(name, T @ centre, size)


def _fields(cell: Cell, parts: tuple[Disc, ...]) -> tuple[FieldPlace, ...]:
    if cell.tray is None:
        return ()
    T = placement_pose(cell.surface[0].pose)
    thick = cell.parts.thickness if cell.parts is not None else max((p.thickness for p in parts), default=0.0)
    return tuple(
        FieldPlace(field.name, T @ pose((*field.corner, 0.0)), field.size, cell.tray.floor + thick)
        for field in cell.tray.fields
    )
