"""What the cell file of an arm may say: one model per TOML table, every value in SI once it is read.

The models are the schema: their field docstrings become the descriptions of the JSON Schema and of error messages.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field, Strict, ValidationInfo, field_validator

from holonom.app.cell_fields import (
    Angle,
    Colour,
    Count,
    File,
    Fraction,
    OneOf,
    Pixel,
    Quantity,
    Section,
    Size,
    Text,
    Vector2,
)
from holonom.app.cell_tables import About, Placement
from holonom.app.units import DIMENSIONS
from holonom.control import CONTROLLERS
from holonom.errors import CellError, OutOfLimits
from holonom.model import preset

__all__ = [
    "ArmCell",
    "ArmTable",
    "Calibration",
    "Camera",
    "Gripper",
    "Limits",
    "Parts",
    "ProgramTable",
    "Table",
    "Tray",
    "TrayField",
]


_DEGREE = DIMENSIONS["angle"]["deg"]


def _known_preset(name: str) -> str:
    return preset(name).name


def _origin() -> Placement:
    return Placement.model_construct(position=(0.0, 0.0, 0.0), angle=0.0)


class ArmTable(Section):
    """The arm and what moves it."""

    preset: Annotated[str, Strict(), AfterValidator(_known_preset)]
    """which arm: the name of a preset"""
    base: Annotated[Placement, Field(default_factory=_origin)]
    """pose of the arm's base in the world, its origin unless given"""
    home: tuple[Angle, ...]
    """joint angles at which a run starts"""
    controllers: Annotated[tuple[Annotated[str, OneOf(CONTROLLERS)], ...], Field(min_length=1)]
    """joint controllers; the program runs once under each, and the report compares them"""

    @field_validator("home")
    @classmethod
    def _home_within_limits(cls, home: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        if "preset" not in info.data:
            return home
        joints = preset(info.data["preset"]).joints
        if len(home) != len(joints):
            raise CellError(f"{len(home)} joint angles came; {info.data['preset']} has {len(joints)} joints")
        for joint, angle in zip(joints, home, strict=True):
            if not joint.limits.lower <= angle <= joint.limits.upper:
                low, high = (f"{bound / _DEGREE:g}deg" for bound in (joint.limits.lower, joint.limits.upper))
                raise OutOfLimits(f"{angle / _DEGREE:g}deg came for {joint.name}; {low} to {high} is allowed")
        return home

    @field_validator("controllers")
    @classmethod
    def _each_once(cls, controllers: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(controllers)) < len(controllers):
            raise CellError(f"{', '.join(controllers)} came; name each controller once")
        return controllers


class Gripper(Section):
    """A parallel gripper on the flange; the tool point lies between the finger tips."""

    length: Annotated[float, Quantity("length", "1mm", "2m")]
    """flange to finger tips"""
    mass: Annotated[float, Quantity("mass", "1g", "100kg")]
    """mass with its fingers"""
    opening: Annotated[float, Quantity("length", "1mm", "1m")]
    """distance of the open fingers"""
    finger: tuple[Size, Size, Size]
    """a finger's width, thickness (in the closing direction) and length"""
    close_time: Annotated[float, Quantity("time", "1ms", "10s")]
    """time from open to closed on nothing"""
    open_time: Annotated[float, Quantity("time", "1ms", "10s")]
    """time from closed to open"""


class Table(Section):
    """The work surface; the table frame has its x and y in the top plane and its origin at one corner."""

    pose: Placement
    """the table frame in the world"""
    size: tuple[Size, Size]
    """extent of the top plane along the table's x and y"""


class Parts(Section):
    """What lies on the table: flat round parts."""

    name: Text
    """kind of the parts, as the program asks for them"""
    thickness: Annotated[float, Quantity("length", "0.1mm", "1m")]
    """height of a part"""
    density: Annotated[float, Quantity("density", "0.01g/cm3", "25g/cm3")]
    """density of their material"""
    grasp_height: Annotated[float, Quantity("length", "0mm", "1m")]
    """height of the finger tips above the table when they grasp a part"""
    layout: File | None = None
    """where the simulated parts truly lie: CSV with u, v, diameter in px; where the camera sees them unless given"""

    @field_validator("grasp_height")
    @classmethod
    def _on_the_part(cls, height: float, info: ValidationInfo) -> float:
        thickness = info.data.get("thickness", height)
        if height > thickness:
            raise OutOfLimits(f"{_mm(height)} came; the fingers would close above a part {_mm(thickness)} thick")
        return height


class Calibration(Section):
    """One point seen in the photograph and measured on the table."""

    pixel: tuple[Pixel, Pixel]
    """u (to the right) and v (downwards) in the photograph"""
    table: Vector2
    """x and y of the same point in the table frame"""


class Camera(Section):
    """The camera over the table."""

    photograph: File
    """image file, relative to the cell file"""
    points: Annotated[tuple[Calibration, ...], Field(min_length=4)]
    """calibration points, four or more, not on one line"""


class TrayField(Section):
    """A grid of places in the tray for parts of one size: columns along the table's x, rows along its y."""

    name: Text
    """what the field is called"""
    corner: Vector2
    """its corner of least x and y, in the table frame"""
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

    @field_validator("max_diameter")
    @classmethod
    def _a_range(cls, largest: float, info: ValidationInfo) -> float:
        least, pitch = info.data.get("min_diameter", 0.0), info.data.get("pitch", largest)
        if not least < largest <= pitch:
            raise OutOfLimits(
                f"{_mm(largest)} came; above min_diameter, {_mm(least)}, and up to pitch, {_mm(pitch)}, is allowed"
            )
        return largest


class Tray(Section):
    """A shallow tray on the table."""

    corner: Vector2
    """its corner of least x and y, in the table frame"""
    size: tuple[Size, Size]
    """extent along the table's x and y"""
    floor: Annotated[float, Quantity("length", "0mm", "1m")]
    """height of the tray's floor above the table"""
    fields: Annotated[tuple[TrayField, ...], Field(min_length=1)]
    """where parts of which size go"""

    @field_validator("fields")
    @classmethod
    def _fields_fit(cls, fields: tuple[TrayField, ...], info: ValidationInfo) -> tuple[TrayField, ...]:
        for number, field in enumerate(fields):
            for other in fields[:number]:
                _check_apart(field, other)
            if "corner" in info.data and "size" in info.data:
                _check_inside(f"field {field.name!r}", *_extent(field), info.data["corner"], info.data["size"])
        return fields


class ProgramTable(Section):
    """The robot program."""

    file: File
    """ARPS file, relative to the cell file"""
    locations: File | None = None
    """file of taught locations, relative to the cell file"""
    entry: Text | None = None
    """program to start, the first of the file unless given"""


class Limits(Section):
    """What the cell allows the arm."""

    joint_speed: Fraction = 1.0
    """fraction of the joints' greatest speeds that the program's 100 % means"""
    joint_acceleration: Fraction = 1.0
    """fraction of the joints' greatest accelerations"""
    line_speed: Annotated[float, Quantity("speed", "1mm/s", "10m/s")]
    """tool speed on straight lines that the program's 100 % means"""
    line_acceleration: Annotated[float, Quantity("acceleration", "1mm/s2", "100m/s2")]
    """tool acceleration on straight lines"""
    rotation_speed: Annotated[float, Quantity("angular speed", "0.1deg/s", "3600deg/s")]
    """greatest turning speed of the tool on straight lines"""
    rotation_acceleration: Annotated[float, Quantity("angular acceleration", "0.1deg/s2", "100000deg/s2")]
    """greatest angular acceleration of the tool on straight lines"""
    following_error: Annotated[float, Quantity("angle", "0.001deg", "90deg")]
    """joint tracking error at which the run stops"""


class ArmCell(Section):
    """The cell file of an arm. Lengths in m, angles in rad, times in s, masses in kg; files are paths that exist."""

    cell: About
    """the cell as a whole"""
    arm: ArmTable
    """the arm and what moves it"""
    gripper: Gripper
    """the gripper on the flange"""
    table: Table
    """the work surface"""
    program: ProgramTable
    """the robot program"""
    limits: Limits
    """what the cell allows the arm"""
    parts: Parts | None = None
    """what lies on the table"""
    camera: Camera | None = None
    """the camera over the table, needs [parts]"""
    tray: Tray | None = None
    """where parts go"""

    @field_validator("camera")
    @classmethod
    def _camera_sees_parts(cls, camera: Camera | None, info: ValidationInfo) -> Camera | None:
        if camera is not None and info.data.get("parts", ...) is None:
            raise CellError("a camera came without the parts that it sees; add a table [parts]")
        return camera

    @field_validator("tray")
    @classmethod
    def _tray_fits(cls, tray: Tray | None, info: ValidationInfo) -> Tray | None:
        table, gripper = info.data.get("table"), info.data.get("gripper")
        if tray is not None and table is not None:
            _check_inside("the tray", tray.corner, tray.size, (0.0, 0.0), table.size)
        if tray is not None and gripper is not None:
            for field in tray.fields:
                if field.max_diameter > gripper.opening:
                    raise OutOfLimits(
                        f"field {field.name!r} takes parts up to {_mm(field.max_diameter)}; "
                        f"the gripper opens to {_mm(gripper.opening)}"
                    )
        return tray


def _mm(length: float) -> str:
    return f"{length * 1e3:g}mm"


def _extent(field: TrayField) -> tuple[tuple[float, float], tuple[float, float]]:
    """Corner and size of a field."""
    return field.corner, (field.columns * field.pitch, field.rows * field.pitch)


def _check_apart(field: TrayField, other: TrayField) -> None:
    """Two fields have different names, sizes of part and places."""
    if field.name == other.name:
        raise CellError(f"two fields are called {field.name!r}; give each its own name")
    if field.min_diameter < other.max_diameter and other.min_diameter < field.max_diameter:
        raise CellError(f"fields {other.name!r} and {field.name!r} claim the same diameters; part their ranges")
    (corner, size), (corner2, size2) = _extent(field), _extent(other)
    if all(corner[k] < corner2[k] + size2[k] and corner2[k] < corner[k] + size[k] for k in (0, 1)):
        raise CellError(f"fields {other.name!r} and {field.name!r} overlap; move one of them")


def _check_inside(
    name: str,
    corner: tuple[float, float],
    size: tuple[float, float],
    outer_corner: tuple[float, float],
    outer_size: tuple[float, float],
) -> None:
    for k, axis in enumerate("xy"):
        low, high = corner[k], corner[k] + size[k]
        outer_low, outer_high = outer_corner[k], outer_corner[k] + outer_size[k]
        if low < outer_low - 1e-9 or high > outer_high + 1e-9:
            raise OutOfLimits(
                f"{name} spans {axis} = {_mm(low)} to {_mm(high)}; {_mm(outer_low)} to {_mm(outer_high)} is there"
            )
