"""What is around the robots: surfaces, parts, a tray, a camera, obstacles, the floor."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict, ValidationInfo, field_validator, model_validator

from holonom.app.cell.model.places import Placement
from holonom.app.fields.quantities import Angle, Colour, Count, OwnFile, Pixel, Quantity, Section, Size, Text, Vector2
from holonom.errors import CellError, OutOfLimits

__all__ = [
    "About",
    "Calibration",
    "Camera",
    "FloorTable",
    "ObstacleTable",
    "PartTable",
    "Parts",
    "Patch",
    "StepTable",
    "SurfaceTable",
    "Tray",
    "TrayField",
    "check_inside",
    "millimetres",
]


class About(Section):
    """The cell as a whole."""

    name: Text
    """what the cell is called"""
    description: str = ""
    """one sentence for the report"""
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**63)] = 0
    """seed of everything random; the same seed gives the same recording"""
    time_limit: Annotated[float, Quantity("time", "1ms", "1440min")]
    """simulated time after which the run stops"""


class SurfaceTable(Section):
    """A level surface; its frame has x and y in it and its origin at one corner."""

    name: Text
    """what it is called"""
    pose: Placement
    """its frame in the world"""
    size: tuple[Size, Size]
    """its extent along its x and y"""

    @field_validator("pose")
    @classmethod
    def _level(cls, pose: Placement) -> Placement:
        if pose.roll != 0.0 or pose.pitch != 0.0:
            raise OutOfLimits("roll and pitch came; a surface on which parts lie is level: 0deg for both")
        return pose


class PartTable(Section):
    """A flat round part that lies somewhere."""

    name: Text
    """what it is called"""
    kind: Text = "part"
    """what it is one of"""
    radius: Size
    """its radius"""
    thickness: Annotated[float, Quantity("length", "0.1mm", "1m")]
    """its height"""
    mass: Annotated[float, Quantity("mass", "0.01g", "100kg")]
    """its mass"""
    pose: Placement
    """middle of its lower face in the world"""


class ObstacleTable(Section):
    """Something that nothing may hit: a box of `size`, or an upright cylinder of `radius` and `height`."""

    name: Text
    """what it is called"""
    pose: Placement
    """its middle in the world"""
    size: tuple[Size, Size, Size] | None = None
    """of a box, along its x, y and z"""
    radius: Size | None = None
    """of a cylinder"""
    height: Size | None = None
    """of a cylinder"""

    @model_validator(mode="after")
    def _one_of_two(self) -> ObstacleTable:
        round_ = (self.radius is not None, self.height is not None)
        if round_ not in ((True, True), (False, False)) or (self.size is None) == (round_ == (False, False)):
            raise CellError(f"obstacle {self.name!r} needs size, or radius and height, one of the two")
        if self.pose.roll or self.pose.pitch:
            raise CellError(f"obstacle {self.name!r} is tilted; it stands upright: roll and pitch are 0")
        return self


class Parts(Section):
    """What the camera sees on the surface: flat round parts."""

    name: Text
    """kind of the parts, as the program asks for them"""
    thickness: Annotated[float, Quantity("length", "0.1mm", "1m")]
    """height of a part"""
    density: Annotated[float, Quantity("density", "0.01g/cm3", "25g/cm3")]
    """density of their material"""
    grasp_height: Annotated[float, Quantity("length", "0mm", "1m")]
    """height of the finger tips above the table when they grasp a part"""
    layout: OwnFile | None = None
    """where the simulated parts truly lie: CSV with u, v, diameter in px; where the camera sees them unless given"""

    @field_validator("grasp_height")
    @classmethod
    def _on_the_part(cls, height: float, info: ValidationInfo) -> float:
        thickness = info.data.get("thickness", height)
        if height > thickness:
            raise OutOfLimits(
                f"{millimetres(height)} came; the fingers would close above a part {millimetres(thickness)} thick"
            )
        return height


class Calibration(Section):
    """One point seen in the photograph and measured on the table."""

    pixel: tuple[Pixel, Pixel]
    """u (to the right) and v (downwards) in the photograph"""
    table: Vector2
    """x and y of the same point in the surface's frame"""


class Camera(Section):
    """The camera over a surface, the first one of the cell."""

    photograph: OwnFile
    """image file, relative to the cell file"""
    points: Annotated[tuple[Calibration, ...], Field(min_length=4)]
    """calibration points, four or more, not on one line"""


class TrayField(Section):
    """A grid of places in the tray for parts of one size: columns along the surface's x, rows along its y."""

    name: Text
    """what the field is called"""
    corner: Vector2
    """its corner of least x and y, in the surface's frame"""
    columns: Count
    """places along x"""
    rows: Count
    """places along y"""
    pitch: Size
    """distance of neighbouring places; the first lies half a pitch from the corner"""
    min_diameter: Annotated[float, Quantity("length", "0mm", "1m")]
    """least diameter of a part that belongs here"""
    max_diameter: Annotated[float, Quantity("length", "0mm", "1m")]
    """diameter from which a part no longer belongs here"""
    colour: Colour
    """colour in the report, as "#rrggbb\""""

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y, m."""
        return self.columns * self.pitch, self.rows * self.pitch

    @field_validator("max_diameter")
    @classmethod
    def _a_range(cls, largest: float, info: ValidationInfo) -> float:
        least, pitch = info.data.get("min_diameter", 0.0), info.data.get("pitch", largest)
        if not least < largest <= pitch:
            raise OutOfLimits(
                f"{millimetres(largest)} came; above min_diameter, {millimetres(least)}, and up to pitch, "
                f"{millimetres(pitch)}, is allowed"
            )
        return largest


class Tray(Section):
    """A shallow tray on a surface, the first one of the cell."""

    corner: Vector2
    """its corner of least x and y, in the surface's frame"""
    size: tuple[Size, Size]
    """extent along the surface's x and y"""
    floor: Annotated[float, Quantity("length", "0mm", "1m")]
    """height of the tray's floor above the surface"""
    fields: Annotated[tuple[TrayField, ...], Field(min_length=1)]
    """where parts of which size go"""

    @field_validator("fields")
    @classmethod
    def _fields_fit(cls, fields: tuple[TrayField, ...], info: ValidationInfo) -> tuple[TrayField, ...]:
        for number, field in enumerate(fields):
            for other in fields[:number]:
                _check_apart(field, other)
            if "corner" in info.data and "size" in info.data:
                check_inside(f"field {field.name!r}", field.corner, field.size, info.data["corner"], info.data["size"])
        return fields


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


class StepTable(Section):
    """An edge across the floor, a straight line, beyond which the floor is higher."""

    position: Vector2
    """a point of the edge, in the world"""
    height: Annotated[float, Quantity("length", "0.1mm", "1m")]
    """how much higher; wheels roll over one that is lower than their radius"""
    rise: Angle = 0.0
    """direction in which the floor rises, in the world"""


class FloorTable(Section):
    """The floor: a slip curve, a slope, steps; `[[patch]]` is where it is another one."""

    friction: Annotated[float, Quantity("number", 0.001, 5.0)] = 0.8
    """largest friction coefficient between wheel and floor"""
    sliding_friction: Annotated[float, Quantity("number", 0.0, 5.0)] = 0.65
    """friction coefficient of a wheel that slides"""
    slip_at_peak: Annotated[float, Quantity("speed", "1mm/s", "10m/s")] = 0.05
    """speed of the rim over the ground at which friction is largest"""
    slope: Annotated[float, Quantity("angle", "-60deg", "60deg")] = 0.0
    """angle of the whole floor against the horizontal; places are measured along it"""
    uphill: Angle = 0.0
    """direction in which a sloping floor rises, in the world"""
    steps: tuple[StepTable, ...] = ()
    """edges across it"""

    @model_validator(mode="after")
    def _falls(self) -> FloorTable:
        _check_friction(self.friction, self.sliding_friction)
        return self


def millimetres(length: float) -> str:
    """Return a length (m) as a cell says it."""
    return f"{length * 1e3:g}mm"


def check_inside(
    name: str,
    corner: tuple[float, float],
    size: tuple[float, float],
    outer_corner: tuple[float, float],
    outer_size: tuple[float, float],
) -> None:
    """Raise `OutOfLimits` where a rectangle is not within another one."""
    for k, axis in enumerate("xy"):
        low, high = corner[k], corner[k] + size[k]
        outer_low, outer_high = outer_corner[k], outer_corner[k] + outer_size[k]
        if low < outer_low - 1e-9 or high > outer_high + 1e-9:
            raise OutOfLimits(
                f"{name} spans {axis} = {millimetres(low)} to {millimetres(high)}; "
                f"{millimetres(outer_low)} to {millimetres(outer_high)} is there"
            )


def _check_apart(field: TrayField, other: TrayField) -> None:
    """Two fields have different names, sizes of part and places."""
    if field.name == other.name:
        raise CellError(f"two fields are called {field.name!r}; give each its own name")
    if field.min_diameter < other.max_diameter and other.min_diameter < field.max_diameter:
        raise CellError(f"fields {other.name!r} and {field.name!r} claim the same diameters; part their ranges")
    (corner, size), (corner2, size2) = (field.corner, field.size), (other.corner, other.size)
    if all(corner[k] < corner2[k] + size2[k] and corner2[k] < corner[k] + size[k] for k in (0, 1)):
        raise CellError(f"fields {other.name!r} and {field.name!r} overlap; move one of them")


def _check_friction(largest: float, sliding: float) -> None:
    if not (sliding < largest or sliding == largest == 0.0):
        raise OutOfLimits(
            f"friction {largest:g} and sliding_friction {sliding:g} came; sliding friction is the smaller"
        )
