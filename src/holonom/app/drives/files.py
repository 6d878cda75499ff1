"""Reading the file of a motor or an axis: `[motor]`, and what hangs on it."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from holonom.app.drives.other_motors import other_motor
from holonom.app.drives.values import ALSO, PlainOrQuantity, sheet_table
from holonom.app.fields.quantities import Section
from holonom.app.fields.toml_faults import line_of, parse_toml, worded_faults
from holonom.app.fields.toml_lines import key_lines
from holonom.devices import MotorCard, MotorSheet, motor_card
from holonom.errors import InputError, ModelError
from holonom.files import read_text
from holonom.registry import parameters_of

__all__ = [
    "AxisFile",
    "SupplyTable",
    "is_cell",
    "is_drive",
    "is_other_motor",
    "is_process",
    "read_axis",
    "read_model",
    "written_motor",
]


CELL = frozenset({"arm", "base", "robot"})
"""Tables of which a cell has one."""


class SupplyTable(Section):
    """What drives the motor."""

    voltage: Annotated[float | None, PlainOrQuantity("V", above=0.0)] = None
    """of the supply; the motor's nominal one unless given"""
    current_limit: Annotated[float | None, PlainOrQuantity("A", above=0.0)] = None
    """of the power stage"""


class GearTable(Section):
    """Between motor and load."""

    ratio: Annotated[float, PlainOrQuantity("")] = 1.0
    """motor turns per turn of the load"""
    efficiency: Annotated[float, PlainOrQuantity("", above=0.0, most=1.0)] = 1.0
    """part of the power that arrives"""
    gap: Annotated[float, PlainOrQuantity("rad", least=0.0)] = 0.0
    """play at the load"""
    stiffness: Annotated[float | None, PlainOrQuantity("N m/rad", above=0.0)] = None
    """at the load; stiff unless given"""


class LoadTable(Section):
    """What is moved."""

    inertia: Annotated[float | None, PlainOrQuantity("kg m2", above=0.0)] = None
    """of the load, at its own shaft; none unless given"""
    coulomb: Annotated[float, PlainOrQuantity("N m", least=0.0)] = 0.0
    """friction"""
    viscous: Annotated[float, PlainOrQuantity("N m s/rad", least=0.0)] = 0.0
    """friction over speed"""


class EncoderTable(Section):
    """On the motor's shaft."""

    counts: Annotated[int, Field(ge=4, le=10_000_000, strict=True)]
    """per turn, after decoding"""


class SampleTable(Section):
    """Times between samples of the loops."""

    current: Annotated[float, PlainOrQuantity("s", above=0.0)] = 1e-4
    """of the current loop"""
    speed: Annotated[float, PlainOrQuantity("s", above=0.0)] = 5e-4
    """of the speed loop"""
    position: Annotated[float, PlainOrQuantity("s", above=0.0)] = 1e-3
    """of the position loop"""


class WantedTable(Section):
    """What the axis is to do; the keys of `holonom tune` may be there too."""

    model_config = ConfigDict(extra="allow", frozen=True, use_attribute_docstrings=True)

    speed: Annotated[float | None, PlainOrQuantity("rad/s", above=0.0)] = None
    """of the load"""


@dataclass(frozen=True, slots=True)
class AxisFile:
    """A motor or an axis as its file has it; tables that are not there are None."""

    path: Path
    motor: MotorCard
    supply: SupplyTable | None = None
    gear: GearTable | None = None
    load: LoadTable | None = None
    encoder: EncoderTable | None = None
    sample: SampleTable | None = None
    wanted: WantedTable | None = None

    @property
    def kind(self) -> str:
        """It is "axis" where more than the motor is there, else "motor"."""
        parts = (self.supply, self.gear, self.load, self.encoder, self.sample, self.wanted)
        return "axis" if any(part is not None for part in parts) else "motor"


def is_drive(path: Path) -> bool:
    """Whether a TOML file has a `motor` at its top (not several, as load cycles have), and no robot, as cells have.

    What cannot be read has neither.
    """
    tables = _tables(path)
    return "motor" in tables and not isinstance(tables["motor"], list) and not is_cell(path)


def is_process(path: Path) -> bool:
    """Whether a TOML file has a `process` at its top, and no robot, as cells have; what cannot be read is none."""
    return "process" in _tables(path) and not is_cell(path)


def is_other_motor(path: Path) -> bool:
    """Whether its table `[motor]` is that of a synchronous, stepping or induction motor."""
    return other_motor(_tables(path).get("motor")) is not None


def is_cell(path: Path) -> bool:
    """Whether a TOML file has a robot, as cells have; what cannot be read is none."""
    return bool(CELL & _tables(path).keys())


def _tables(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(read_text(path, "drive", ModelError))
    except (InputError, ValueError, RecursionError):
        return {}


def read_axis(path: Path) -> AxisFile:
    """Read the file of a motor or an axis.

    Raises
    ------
    ModelError
        A line for each fault: file, line, key, what came, what is expected.
    """
    optional: dict[str, Any] = {
        name: (table | None, None)
        for name, table in {
            "supply": SupplyTable, "gear": GearTable, "load": LoadTable, "encoder": EncoderTable,
            "sample": SampleTable, "wanted": WantedTable,
        }.items()
    }  # fmt: skip
    model = create_model("AxisTables", __base__=Section, motor=(sheet_table(), ...), **optional)
    found, text = read_model(path, model)
    tables = {name: getattr(found, name) for name in optional}
    return AxisFile(path, written_motor(path, text, getattr(found, "motor"), "motor"), **tables)  # noqa: B009


def read_model(path: Path, model: type[BaseModel]) -> tuple[BaseModel, str]:
    """Read a TOML file into a model; also its text.

    Raises
    ------
    ModelError
        As `read_axis`.
    """
    text = read_text(path, "drive", ModelError)
    data = parse_toml(path, text, ModelError, "R = 1.13")
    try:
        return model.model_validate(data), text
    except ValidationError as error:
        raise ModelError(worded_faults(path, text, model, error.errors(include_url=False))) from None


def written_motor(path: Path, text: str, table: Any, key: str) -> MotorCard:
    """Return the motor of a table: that of its preset, or of its sheet.

    Raises
    ------
    ModelError
        No such preset, a preset with other numbers beside it, no number at all.
    """
    numbers = {f.name: getattr(table, f.name) for f in parameters_of(MotorSheet)}
    numbers |= {name: getattr(table, also) for also, name in ALSO.items() if getattr(table, also) is not None}
    printed = {name: value for name, value in numbers.items() if value is not None}
    place = f"{path}:{line_of((key,), key_lines(text))}: {key}"
    if table.preset is not None:
        if printed:
            raise ModelError(f"{place}: preset and {', '.join(printed)} came; give a preset, or the numbers of a sheet")
        try:
            return motor_card(table.preset)
        except InputError as problem:
            raise ModelError(f"{place}.preset: {problem}") from None
    if not printed:
        raise ModelError(
            f"{place}: no number of a sheet came, and no preset; give preset = NAME, or U, R, L, kM, J, ..."
        )
    name = table.name or path.stem
    return MotorCard(name, name, MotorSheet(**printed), table.source or str(path))
