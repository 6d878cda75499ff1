"""What the keys of a cell file may hold: quantities with units, files, colours; and what every table is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler, Strict, ValidationInfo
from pydantic_core import core_schema

from holonom.app.fields.units import DIMENSIONS, parse_quantity
from holonom.errors import CellError, OutOfLimits, UnknownName
from holonom.files import is_file, is_inside

__all__ = [
    "Angle",
    "Colour",
    "Count",
    "ExistingFile",
    "File",
    "Fraction",
    "Length",
    "OneOf",
    "OwnFile",
    "Pixel",
    "Quantity",
    "Section",
    "Size",
    "Text",
    "Vector2",
    "Vector3",
]


@dataclass(frozen=True, slots=True)
class Quantity:
    """Reads a quantity with its unit into SI; `low` and `high`, themselves so written, are still allowed."""

    dimension: str
    low: str | float
    high: str | float

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        if self.dimension == "number":
            return {"type": "number", "minimum": self.low, "maximum": self.high}
        units = "|".join(DIMENSIONS[self.dimension])
        return {"type": "string", "pattern": rf"^\s*[+-]?(\d+(?:\.\d*)?|\.\d+)([eE][+-]?\d+)?\s*({units})\s*$"}

    def _read(self, value: object) -> float:
        number = parse_quantity(value, self.dimension)
        low, high = (parse_quantity(bound, self.dimension) for bound in (self.low, self.high))
        if not low <= number <= high:
            raise OutOfLimits(f"{value!r} came; {self.low} to {self.high} is allowed")
        return number


@dataclass(frozen=True, slots=True)
class ExistingFile:
    """Reads a path relative to the cell file (context "folder") of a file that is there.

    One that is `own` lies in that folder or below it, links followed, unless the context says "outside".
    """

    own: bool = False

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.with_info_after_validator_function(
            self._read, core_schema.str_schema(strict=True, min_length=1)
        )

    def _read(self, name: str, info: ValidationInfo) -> Path:
        context = info.context or {}
        folder = Path(context.get("folder", "."))
        if self.own and not context.get("outside") and not is_inside(folder / name, folder):
            raise CellError(
                f"{name!r} leads out of the cell's folder {folder}; copy the file into it, or run with --allow-outside "
                "if you mean it"
            )
        if not is_file(folder / name):
            raise CellError(f"no file {name!r} in {folder}; put it there or give its path relative to the cell file")
        return folder / name


@dataclass(frozen=True, slots=True)
class OneOf:
    """Reads a name that a table lists: the table, or the names that there are."""

    names: Iterable[str]

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"enum": list(self.names), "type": "string"}

    def _read(self, value: object) -> str:
        if not isinstance(value, str) or value not in self.names:
            raise UnknownName("setting", str(value), self.names)
        return value


Text = Annotated[str, Strict(), Field(min_length=1)]
Count = Annotated[int, Strict(), Field(ge=1, le=1000)]
Length = Annotated[float, Quantity("length", "-100m", "100m")]
Size = Annotated[float, Quantity("length", "0.1mm", "100m")]
Angle = Annotated[float, Quantity("angle", "-360deg", "360deg")]
Fraction = Annotated[float, Quantity("number", 0.01, 1.0)]
Pixel = Annotated[float, Quantity("number", -1e5, 1e5)]
Colour = Annotated[str, Strict(), Field(pattern="^#[0-9a-fA-F]{6}$")]
File = Annotated[Path, ExistingFile()]
OwnFile = Annotated[Path, ExistingFile(own=True)]
Vector2 = tuple[Length, Length]
Vector3 = tuple[Length, Length, Length]


class Section(BaseModel):
    """One TOML table: frozen, and no key that is not named."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)
