"""`Cell`: what a cell file says, in lists of tables; every value in SI once it is read.

The models are the schema: their field docstrings become the descriptions of the JSON Schema and of error messages.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from pydantic import Field, ValidationInfo, field_validator, model_validator

from holonom.app.cell.model.refusals import Faults, refuse
from holonom.app.cell.model.robot import GripperTool, Robot
from holonom.app.cell.model.sensor import ReadSensor, Sensor
from holonom.app.cell.model.tasks import FAULTS, EventTable, FaultTable
from holonom.app.cell.model.world import (
    About,
    Camera,
    FloorTable,
    ObstacleTable,
    Parts,
    PartTable,
    Patch,
    SurfaceTable,
    Tray,
    check_inside,
    millimetres,
)
from holonom.app.fields.quantities import Section
from holonom.app.recording.scope import COMMON
from holonom.errors import CellError, OutOfLimits, UnknownName
from holonom.signals import Kind

__all__ = ["FRAMES", "Cell"]

FRAMES = ("base_link", "top")
"""Frames of a base on which other robots can stand."""


class Cell(Section):
    """A cell file. Lengths in m, angles in rad, times in s, masses in kg; files are paths that exist."""

    cell: About
    """the cell as a whole"""
    robot: Annotated[tuple[Robot, ...], Field(min_length=1)]
    """the robots; or a table [arm] or [base] for one"""
    surface: tuple[SurfaceTable, ...] = ()
    """on what parts lie"""
    parts: Parts | None = None
    """what the camera sees on the first surface"""
    camera: Camera | None = None
    """the camera over the first surface, needs [parts]"""
    tray: Tray | None = None
    """where parts go, on the first surface"""
    part: tuple[PartTable, ...] = ()
    """parts beside those that the camera sees"""
    obstacle: tuple[ObstacleTable, ...] = ()
    """what nothing may hit"""
    floor: Annotated[FloorTable, Field(default_factory=lambda: FloorTable.model_construct())]
    """what bases drive on"""
    patch: tuple[Patch, ...] = ()
    """ice, oil, carpet"""
    sensor: tuple[Annotated[Sensor, ReadSensor()], ...] = ()
    """what measures"""
    fault: tuple[FaultTable, ...] = ()
    """what breaks"""
    event: tuple[EventTable, ...] = ()
    """what happens at a time"""

    @field_validator("camera")
    @classmethod
    def _camera_sees_parts(cls, camera: Camera | None, info: ValidationInfo) -> Camera | None:
        if camera is None:
            return None
        if info.data.get("parts", ...) is None:
            raise CellError("a camera came without the parts that it sees; add a table [parts]")
        if info.data.get("surface", ...) == ():
            raise CellError("a camera came without the surface that it sees; add a table [table] or [[surface]]")
        return camera

    @field_validator("tray")
    @classmethod
    def _tray_fits(cls, tray: Tray | None, info: ValidationInfo) -> Tray | None:
        surfaces = info.data.get("surface", ...)
        if tray is not None and surfaces == ():
            raise CellError("a tray came without a surface that it stands on; add a table [table] or [[surface]]")
        if tray is not None and surfaces is not ...:
            check_inside("the tray", tray.corner, tray.size, (0.0, 0.0), surfaces[0].size)
        hands = [robot.tool for robot in info.data.get("robot", ()) if isinstance(robot.tool, GripperTool)]
        if tray is not None and hands:
            widest = max(hand.opening for hand in hands)
            for field in tray.fields:
                if field.max_diameter > widest:
                    raise OutOfLimits(
                        f"field {field.name!r} takes parts up to {millimetres(field.max_diameter)}; "
                        f"the gripper opens to {millimetres(widest)}"
                    )
        return tray

    @model_validator(mode="after")
    def _names_fit(self) -> Cell:
        faults = Faults()
        for key in ("robot", "surface", "part", "obstacle", "patch"):
            faults.call((), self._each_once, key)
        for number, robot in enumerate(self.robot):
            faults.call(("robot", number), self._check_robot, robot)
        for number, sensor in enumerate(self.sensor):
            faults.call(("sensor", number, "robot"), self.robot_of, sensor.robot)
        faults.call((), self._each_sensor_once)
        for number, fault in enumerate(self.fault):
            faults.call(("fault", number), self._check_fault, fault)
        for number, event in enumerate(self.event):
            faults.call(("event", number), self._check_event, event)
        faults.raise_any()
        return self

    def _each_once(self, key: str) -> None:
        names: list[str] = []
        for number, table in enumerate(getattr(self, key)):
            if table.name in names:
                raise refuse((key, number, "name"), f"two tables [[{key}]] are called {table.name!r}; name each once")
            if key == "robot" and table.name == "" and len(self.robot) > 1:
                raise refuse((key, number, "name"), "missing; each of several robots needs a name")
            if key == "robot" and table.name in _TAKEN:
                raise refuse((key, number, "name"), f"{table.name!r} came, which topics use themselves; take another")
            names.append(table.name)

    def _each_sensor_once(self) -> None:
        seen: list[tuple[str, str]] = []
        for number, sensor in enumerate(self.sensor):
            if sensor.robot is None and len(self.robot) > 1:
                continue
            name = (self.robot_of(sensor.robot).name, sensor.name)
            if name in seen:
                raise refuse(("sensor", number, "name"), f"two sensors are called {sensor.name!r}; name each once")
            seen.append(name)

    def _check_robot(self, robot: Robot) -> None:
        if robot.on is None:
            return
        carrier, _, frame = robot.on.partition(".")
        names = [other.name for other in self.robot if other is not robot]
        if carrier == robot.name:
            raise refuse(("on",), f"{robot.on!r} came; a robot cannot stand on itself")
        if carrier not in names:
            raise refuse(("on",), UnknownName("robot", carrier, names))
        if next(other for other in self.robot if other.name == carrier).is_arm:
            raise refuse(("on",), f"{carrier!r} is an arm; a robot stands on a base, at {' or '.join(FRAMES)}")
        if frame and frame not in FRAMES:
            raise refuse(("on",), UnknownName(f"frame of {carrier!r}", frame, FRAMES))

    def _check_event(self, event: EventTable) -> None:
        if event.payload is None:
            return
        try:
            robot = self.robot_of(event.robot)
        except CellError as problem:
            raise refuse(("robot",), problem) from None
        if robot.is_arm:
            raise refuse(("robot",), f"{robot.name!r} is an arm; bases carry payloads")
        if robot.drives == "ideal":
            raise refuse(("payload",), "it came; ideal drives feel no payload: state motors, or leave it out")

    def _check_fault(self, fault: FaultTable) -> None:
        try:
            robot = self.robot_of(fault.robot)
        except CellError as problem:
            raise refuse(("robot",), problem) from None
        if robot.is_arm:
            raise refuse(("robot",), f"{robot.name!r} is an arm; motors of bases can break")
        base = robot.source.base
        if FAULTS[fault.kind] == "stuck":
            kind, known = "steered wheel", [wheel.name for wheel in base.wheels if wheel.steers]
        else:
            kind, known = "driven wheel", list(base.driven)
        if fault.wheel not in known:
            raise refuse(("wheel",), UnknownName(kind, fault.wheel, known), fault.wheel)

    def robot_of(self, name: str | None) -> Robot:
        """Return the robot of a name; for None the only one.

        Raises
        ------
        CellError
            No such robot, or several where one was to be named.
        """
        if name is None and len(self.robot) == 1:
            return self.robot[0]
        names = [robot.name for robot in self.robot]
        if name is None:
            raise CellError(f"missing; there are several robots: {_listed(names)}")
        if name not in names:
            raise CellError(str(UnknownName("robot", name, names)))
        return self.robot[names.index(name)]


_TAKEN = (*Kind, *COMMON, "signals")


def _listed(names: Iterable[str]) -> str:
    return ", ".join(sorted(names))
