"""What a robot is to do: a program, a path, velocities, holding; and what happens beside it."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import Field, Strict, ValidationInfo, field_validator, model_validator

from holonom.app.fields.methods import Chosen, OneMethod
from holonom.app.fields.quantities import Angle, Count, Length, OneOf, OwnFile, Quantity, Section, Size, Text, Vector2
from holonom.control import PATH_LAWS
from holonom.errors import CellError
from holonom.machine.base.paths import HEADINGS, PATHS
from holonom.machine.base.settings import KEEP
from holonom.sim.base.plant import FAULTS as BASE_FAULTS

__all__ = [
    "FAULTS",
    "EventTable",
    "FaultTable",
    "PathTable",
    "PayloadTable",
    "ProgramTable",
    "SignalNumber",
    "StartTable",
    "TwistTable",
]

_PARTS = {"stuck": "steering_stuck", "frozen": "encoder_stuck", "off": "wheel_lost"}
FAULTS = {_PARTS.get(name, f"motor_{name}"): name for name in BASE_FAULTS}
"""What a cell calls what breaks of a base."""

SignalNumber = Annotated[int, Strict(), Field(ge=1, le=100_000)]
Moment = Annotated[float, Quantity("time", "0ms", "1440min")]


class ProgramTable(Section):
    """The robot program."""

    file: OwnFile
    """ARPS file, relative to the cell file"""
    locations: Annotated[OwnFile | None, Field(validate_default=True)] = None
    """file of taught locations, relative to the cell file"""
    entry: Text | None = None
    """program to start, the first of the file unless given"""

    @model_validator(mode="before")
    @classmethod
    def _of_a_name(cls, given: Any) -> Any:
        return {"file": given} if isinstance(given, str) else given

    @field_validator("locations", mode="before")
    @classmethod
    def _beside(cls, given: Any, info: ValidationInfo) -> Any:
        """Take the file beside the program unless another one is given; it is confined as that one is."""
        program = info.data.get("file")
        beside = None if program is None else program.with_suffix(".loc")
        if given is not None or beside is None or not beside.is_file():
            return given
        return str(beside.relative_to((info.context or {}).get("folder", ".")))


PlanarPose = tuple[Length, Length, Angle]


class PathTable(Section):
    """The path that the base is to drive, from rest to rest."""

    shape: Annotated[str, OneOf(PATHS)]
    """its form"""
    size: Size | None = None
    """its length; of waypoints and poses none"""
    points: Annotated[tuple[Vector2, ...], Field(min_length=2)] | None = None
    """waypoints: the places that it goes through; closed where the last is the first"""
    poses: Annotated[tuple[PlanarPose, ...], Field(min_length=2)] | None = None
    """dubins, reeds_shepp: x, y and heading of each that it goes to; the first is the start"""
    radius: Size | None = None
    """dubins, reeds_shepp: smallest turning radius"""
    origin: Vector2 = (0.0, 0.0)
    """where it lies: middle of the eight, start of the circle, middle of the square's lower side"""
    speed: Annotated[float, Quantity("speed", "1mm/s", "20m/s")]
    """greatest speed on it"""
    acceleration: Annotated[float, Quantity("acceleration", "1mm/s2", "100m/s2")]
    """greatest acceleration on it, along and across together"""
    laps: Count = 1
    """times around"""
    heading: Annotated[str, OneOf(HEADINGS)] | None = None
    """where the base looks: always the same way, along the path, or once around per lap; unless given, the same way; of
    a base that cannot move sideways, and from pose to pose, along the path"""
    angle: Angle = 0.0
    """its heading at the start; against the path where it looks along it"""
    position_tolerance: Size | None = None
    """how far off the path the base may truly be, else the run has failed; 5 % of the larger side of the path's box
    unless given"""
    heading_tolerance: Annotated[float, Quantity("angle", "0.01deg", "180deg")] = math.radians(10.0)
    """how far its true heading may be off"""
    keep: Annotated[str, OneOf(KEEP)] = "both"
    """what is kept once motors are lost and the others cannot hold both: the path, the heading; both are asked unless
    given, so that such a run fails"""

    law: Annotated[Chosen | None, OneMethod(PATH_LAWS)] = None
    """how a base that cannot move sideways keeps it: its name, or { kind = "stanley", gain = ... }; Kanayama's unless
    given. Its limits are those of `limits` and of the base unless it has its own"""

    @model_validator(mode="after")
    def _size_or_points(self) -> PathTable:
        wanted = {field.name for field in PATHS[self.shape].fields}
        own = {"points", "poses", "radius", "size"}
        given = {name for name in own if getattr(self, name) is not None}
        if given != wanted:
            other = " or ".join(sorted(own - wanted))
            raise CellError(f"shape {self.shape!r} takes {' and '.join(sorted(wanted))} and no {other}")
        if "poses" in wanted and ({"heading", "angle", "laps"} & self.model_fields_set):
            raise CellError(f"shape {self.shape!r} takes its headings from its poses; no heading, angle or laps")
        return self


class TwistTable(Section):
    """A velocity of the base in its own axes, from a moment on."""

    at: Moment
    """when, from the start of the task"""
    vx: Annotated[float, Quantity("speed", "-20m/s", "20m/s")] = 0.0
    """forwards"""
    vy: Annotated[float, Quantity("speed", "-20m/s", "20m/s")] = 0.0
    """to the left"""
    w: Annotated[float, Quantity("angular speed", "-3600deg/s", "3600deg/s")] = 0.0
    """turning, counter-clockwise"""
    about: Vector2 = (0.0, 0.0)
    """the place on the base that is to move so, and that it turns about where it has no speed"""

    @property
    def twist(self) -> tuple[float, float, float]:
        """Of base_link, m/s and rad/s."""
        x, y = self.about
        return self.vx + self.w * y, self.vy - self.w * x, self.w


class StartTable(Section):
    """When a task begins: at a time, or when a signal goes on."""

    time: Moment = 0.0
    """from the start of the run"""
    signal: SignalNumber | None = None
    """number of the signal that it waits for"""

    @model_validator(mode="before")
    @classmethod
    def _of_a_time(cls, given: Any) -> Any:
        return {"time": given} if isinstance(given, str) else given

    @model_validator(mode="after")
    def _one_of_two(self) -> StartTable:
        if self.signal is not None and "time" in self.model_fields_set:
            raise CellError("time and signal came; it is one of the two")
        return self


class FaultTable(Section):
    """Something that breaks."""

    time: Moment
    """when"""
    robot: Text | None = None
    """whose; needed where there are several"""
    kind: Annotated[str, OneOf(FAULTS)]
    """a motor without current, whose wheel turns freely, one that is jammed, a steering motor that stays as it is, an
    encoder that counts no more, a wheel that comes off"""
    wheel: Text
    """name of the driven or steered wheel"""


class PayloadTable(Section):
    """What a base carries, as a point."""

    mass: Annotated[float, Quantity("mass", "0g", "5000kg")]
    """its mass; 0kg takes it off"""
    com: Vector2 = (0.0, 0.0)
    """where its middle is in base_link, forwards and to the left"""
    com_height: Annotated[float, Quantity("length", "0mm", "5m")] = 0.0
    """how high that is over the floor"""


class EventTable(Section):
    """Something that happens at a time: a signal is switched, or a base gets another payload."""

    at: Moment
    """when"""
    signal: SignalNumber | None = None
    """number of the signal that is switched"""
    on: Annotated[bool, Strict()] = True
    """whether it goes on or off"""
    payload: PayloadTable | None = None
    """what a base carries from then on, instead of what it carried; its controller is not told"""
    robot: Text | None = None
    """the base that carries it; needed where there are several robots"""

    @model_validator(mode="after")
    def _one_of_two(self) -> EventTable:
        if (self.signal is None) == (self.payload is None):
            raise CellError("an event switches a signal or changes a payload; give it one of signal and payload")
        if self.signal is not None and self.robot is not None:
            raise CellError("robot came beside signal; signals belong to the whole cell")
        return self
