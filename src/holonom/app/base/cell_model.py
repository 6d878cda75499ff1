"""What the cell file of a mobile base may say: one model per TOML table, every value in SI once it is read."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict, ValidationInfo, field_validator, model_validator

from holonom.app.cell_fields import Angle, Count, OneOf, Quantity, Section, Size, Text, Vector2
from holonom.app.cell_tables import About
from holonom.errors import CellError, OutOfLimits, UnknownName
from holonom.machine.base.paths import HEADINGS, PATHS
from holonom.sim.base.plant import FAULTS as MOTOR_FAULTS

__all__ = [
    "BaseCell",
    "BaseTable",
    "ControlTable",
    "DriveTable",
    "Fault",
    "FloorTable",
    "GyroTable",
    "Patch",
    "PathTable",
]

ARRANGEMENTS = {"omni": ("angles", "radius"), "mecanum": ("wheelbase", "track")}
"""Arrangements of driven wheels, and the keys that each needs beside `wheel_radius`."""
FAULTS = {f"motor_{name}": name for name in MOTOR_FAULTS}
"""What a cell calls the faults of motors."""


class BaseTable(Section):
    """The base and its wheels; x forwards, y to the left."""

    arrangement: Annotated[str, OneOf(ARRANGEMENTS)]
    """how the wheels stand"""
    angles: Annotated[tuple[Angle, ...], Field(min_length=3)] | None = None
    """omni: where each motor axis points, counter-clockwise from x"""
    radius: Size | None = None
    """omni: distance of the wheels from the centre"""
    wheelbase: Size | None = None
    """mecanum: distance of front and rear axle"""
    track: Size | None = None
    """mecanum: distance of left and right wheels"""
    wheel_radius: Size
    """radius of the wheels"""
    wheels: tuple[Text, ...] | None = None
    """names of the driven wheels, in their order; those of the arrangement unless given"""
    mass: Annotated[float, Quantity("mass", "1g", "5000kg")]
    """mass with wheels and motors"""
    mass_distribution: Annotated[float, Quantity("number", 0.01, 10.0)] = 0.5
    """alpha of the moment of inertia alpha M R2: 0.5 for a disc, 1 for a ring"""
    height: Annotated[float, Quantity("length", "0mm", "5m")]
    """height of the centre of mass"""

    @model_validator(mode="after")
    def _keys_of_the_arrangement(self) -> BaseTable:
        needed = ARRANGEMENTS[self.arrangement]
        others = {key for keys in ARRANGEMENTS.values() for key in keys} - set(needed)
        missing = [key for key in needed if getattr(self, key) is None]
        spare = sorted(key for key in others if getattr(self, key) is not None)
        if missing or spare:
            wrong = [f"{key} is missing" for key in missing] + [f"{key} came" for key in spare]
            raise CellError(f"{', '.join(wrong)}; arrangement {self.arrangement!r} takes {' and '.join(needed)}")
        count = len(self.angles) if self.angles is not None else 4
        if self.wheels is not None and (len(self.wheels) != count or len(set(self.wheels)) != count):
            raise CellError(f"{len(self.wheels)} names of wheels came; {count} different ones are needed")
        return self


class DriveTable(Section):
    """Motor, gear and encoder of each wheel, all alike."""

    resistance: Annotated[float, Quantity("resistance", "1mohm", "1000ohm")]
    """armature"""
    inductance: Annotated[float, Quantity("inductance", "0.1uH", "10H")]
    """armature"""
    torque_constant: Annotated[float, Quantity("torque constant", "0.01mNm/A", "100Nm/A")]
    """of the motor; its back-emf constant is the same in V s/rad"""
    rotor_inertia: Annotated[float, Quantity("inertia", "0.001gcm2", "10kgm2")]
    """of the motor"""
    no_load_current: Annotated[float, Quantity("current", "0mA", "100A")] = 0.0
    """current of the free motor: its friction"""
    supply: Annotated[float, Quantity("voltage", "1V", "1000V")]
    """voltage of the battery"""
    max_current: Annotated[float, Quantity("current", "1mA", "10000A")]
    """limit of the power stage"""
    gear_ratio: Annotated[float, Quantity("number", 0.1, 1000.0)] = 1.0
    """motor turns per wheel turn"""
    gear_efficiency: Annotated[float, Quantity("number", 0.1, 1.0)] = 1.0
    """part of the motor's power that arrives at the wheel"""
    counts_per_turn: Annotated[int, Strict(), Field(ge=4, le=10_000_000)]
    """encoder counts per turn of the motor, after decoding"""
    wheel_inertia: Annotated[float, Quantity("inertia", "0.001gcm2", "100kgm2")]
    """of a wheel about its axle"""


class GyroTable(Section):
    """The gyro and the accelerometers."""

    noise: Annotated[float, Quantity("angular speed", "0deg/s", "360deg/s")] = 0.0
    """standard deviation of one sample of the turning rate"""
    bias: Annotated[float, Quantity("angular speed", "-360deg/s", "360deg/s")] = 0.0
    """what it shows at rest"""
    acceleration_noise: Annotated[float, Quantity("acceleration", "0m/s2", "100m/s2")] = 0.0
    """standard deviation of one sample of the acceleration"""


class Patch(Section):
    """A patch of another floor: round where `radius` is given, else a rectangle of `size` turned by `angle`."""

    name: Text
    """what it is called"""
    centre: Vector2
    """its centre in the world"""
    radius: Size | None = None
    """of a round patch"""
    size: tuple[Size, Size] | None = None
    """length and width of a rectangle"""
    angle: Angle = 0.0
    """turn of a rectangle"""
    friction: Annotated[float, Quantity("number", 0.0, 5.0)]
    """largest friction coefficient of a wheel on it"""
    sliding_friction: Annotated[float, Quantity("number", 0.0, 5.0)]
    """friction coefficient of a wheel that slides on it"""

    @model_validator(mode="after")
    def _round_or_not(self) -> Patch:
        if (self.radius is None) == (self.size is None):
            raise CellError(f"patch {self.name!r} needs radius or size, one of the two")
        _check_friction(self.friction, self.sliding_friction)
        return self


class FloorTable(Section):
    """The floor: a slip curve, and patches where it is another one."""

    friction: Annotated[float, Quantity("number", 0.001, 5.0)]
    """largest friction coefficient between wheel and floor"""
    sliding_friction: Annotated[float, Quantity("number", 0.0, 5.0)]
    """friction coefficient of a wheel that slides"""
    slip_at_peak: Annotated[float, Quantity("speed", "1mm/s", "10m/s")] = 0.05
    """speed of the rim over the ground at which friction is largest"""
    patches: tuple[Patch, ...] = ()
    """ice, oil, carpet"""

    @model_validator(mode="after")
    def _falls(self) -> FloorTable:
        _check_friction(self.friction, self.sliding_friction)
        return self


class PathTable(Section):
    """The path that the base is to drive, from rest to rest."""

    shape: Annotated[str, OneOf(PATHS)]
    """its form"""
    size: Size | None = None
    """its length; of waypoints none"""
    points: Annotated[tuple[Vector2, ...], Field(min_length=2)] | None = None
    """waypoints: the places that it goes through; closed where the last is the first"""
    origin: Vector2 = (0.0, 0.0)
    """where it lies: middle of the eight, start of the circle, middle of the square's lower side"""
    speed: Annotated[float, Quantity("speed", "1mm/s", "20m/s")]
    """greatest speed on it"""
    acceleration: Annotated[float, Quantity("acceleration", "1mm/s2", "100m/s2")]
    """greatest acceleration on it, along and across together"""
    laps: Count = 1
    """times around"""
    heading: Annotated[str, OneOf(HEADINGS)] = "fixed"
    """where the base looks: always the same way, along the path, or once around per lap"""
    angle: Angle = 0.0
    """its heading at the start; against the path where it looks along it"""

    @model_validator(mode="after")
    def _size_or_points(self) -> PathTable:
        wanted = {field.name for field in PATHS[self.shape].fields}
        given = {name for name in ("points", "size") if getattr(self, name) is not None}
        if given != wanted:
            other = " and ".join(sorted({"points", "size"} - wanted))
            raise CellError(f"shape {self.shape!r} takes {' and '.join(sorted(wanted))} and no {other}")
        return self


class Fault(Section):
    """Something that breaks."""

    time: Annotated[float, Quantity("time", "0ms", "1440min")]
    """when"""
    kind: Annotated[str, OneOf(FAULTS)]
    """a motor without current, whose wheel turns freely, or one that is jammed"""
    wheel: Text
    """name of the driven wheel"""


class ControlTable(Section):
    """What the controller does about slip and dead motors."""

    slip_detection: Annotated[bool, Strict()] = True
    """find the wheel that slips, and leave it out of the velocity estimate"""
    traction_control: Annotated[bool, Strict()] = True
    """cut the force of a wheel that slips"""
    dead_motor_compensation: Annotated[bool, Strict()] = True
    """find a dead motor, and drive with the others"""


class BaseCell(Section):
    """The cell file of a mobile base. Lengths in m, angles in rad, times in s, masses in kg, the rest in SI."""

    cell: About
    """the cell as a whole"""
    base: BaseTable
    """the base and its wheels"""
    drive: DriveTable
    """motor, gear and encoder of each wheel"""
    floor: FloorTable
    """what it drives on"""
    path: PathTable
    """where it drives"""
    gyro: Annotated[GyroTable, Field(default_factory=lambda: GyroTable.model_construct())]
    """its gyro"""
    control: Annotated[ControlTable, Field(default_factory=lambda: ControlTable.model_construct())]
    """what the controller does about faults"""
    faults: tuple[Fault, ...] = ()
    """what breaks"""

    @field_validator("faults")
    @classmethod
    def _wheels_are_there(cls, faults: tuple[Fault, ...], info: ValidationInfo) -> tuple[Fault, ...]:
        base = info.data.get("base")
        if base is not None and base.wheels is not None:
            for fault in faults:
                if fault.wheel not in base.wheels:
                    raise UnknownName("driven wheel", fault.wheel, base.wheels)
        return faults


def _check_friction(largest: float, sliding: float) -> None:
    if not (sliding < largest or sliding == largest == 0.0):
        raise OutOfLimits(
            f"friction {largest:g} and sliding_friction {sliding:g} came; sliding friction is the smaller"
        )
