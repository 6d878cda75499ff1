"""Numbers of a drive's file: plain ones in the key's own unit, or text with a unit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, Field, GetCoreSchemaHandler, create_model
from pydantic_core import core_schema

from holonom.app.fields.quantities import Section, Text
from holonom.app.fields.units import DIMENSIONS, parse_quantity
from holonom.devices import MotorSheet
from holonom.errors import InputError, OutOfLimits
from holonom.registry import parameters_of

__all__ = ["MotorTable", "PlainOrQuantity", "sheet_table"]

KINDS = {
    "V": ("voltage", "V"),
    "A": ("current", "A"),
    "ohm": ("resistance", "ohm"),
    "H": ("inductance", "H"),
    "N m": ("torque", "Nm"),
    "N m/A": ("torque constant", "Nm/A"),
    "kg m2": ("inertia", "kgm2"),
    "s": ("time", "s"),
    "rpm": ("angular speed", "rpm"),
    "rpm/V": ("speed constant", "rpm/V"),
    "rpm/mNm": ("speed gradient", "rpm/mNm"),
    "V/krpm": ("voltage constant", "V/krpm"),
    "K/W": ("thermal resistance", "K/W"),
    "degC": ("temperature", "degC"),
    "rad": ("angle", "rad"),
    "rad/s": ("angular speed", "rad/s"),
    "rad/s2": ("angular acceleration", "rad/s2"),
    "N m/rad": ("stiffness", "Nm/rad"),
    "N m s/rad": ("rotational damping", "Nms/rad"),
    "": ("number", ""),
}
"""Unit of a key: the dimension of its quantities, and how they write that unit."""


LEAST, MOST = 1e-15, 1e15
"""Smallest and largest number of anything, so that no product of some overflows."""


@dataclass(frozen=True, slots=True)
class PlainOrQuantity:
    """Reads a plain number in `unit`, or text with any unit of its dimension, into `unit`; bounds as of a parameter."""

    unit: str
    above: float | None = None
    least: float | None = None
    most: float | None = None

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self._read)

    def _read(self, value: object) -> float:
        dimension, written = KINDS[self.unit]
        if isinstance(value, str) and dimension != "number":
            number = parse_quantity(value, dimension) / DIMENSIONS[dimension][written]
        elif isinstance(value, (int, float)) and not isinstance(value, bool):
            number = float(value) if abs(value) <= MOST else math.inf
        else:
            also = f', or text such as "2.5{written}"' if written else ""
            raise InputError(f"{value!r} came; a number{' in ' + written if written else ''} is expected{also}")
        if self.above == 0.0 and 0.0 < number < LEAST:
            raise OutOfLimits(f"{value!r} came; at least {LEAST:g} {written} is read".rstrip())
        low = (self.above is None or number > self.above) and (self.least is None or number >= self.least)
        if not (math.isfinite(number) and low and (self.most is None or number <= self.most)):
            bounds = {"greater than": self.above, "at least": self.least, "at most": self.most}
            allowed = [f"{word} {bound:g}" for word, bound in bounds.items() if bound is not None]
            raise OutOfLimits(f"{value!r} came; it must be {' and '.join(['finite', *allowed])} {written}".rstrip())
        return number


ALSO = {"n0_rpm": "n0", "nN_rpm": "nN", "kn_rpm_per_V": "kn", "tau_w": "tw", "tau_s": "ts"}
"""Keys with their unit, as some tables of data sheets write them."""


class MotorTable(Section):
    """A motor: one that can be bought by its name, or what its sheet prints."""

    preset: Text | None = None
    """name of a motor, of `holonom methods motors`"""
    name: Text | None = None
    """what the motor is called"""
    source: Text | None = None
    """where its numbers are from"""
    note: Text | None = None
    """anything else"""


def sheet_table() -> type[BaseModel]:
    """Return the model of a table `[motor]`: `MotorTable` with every key of `MotorSheet`."""
    keys: dict[str, Any] = {}
    for field in parameters_of(MotorSheet):
        limit = field.parameter
        reads = PlainOrQuantity(limit.unit, above=limit.above, least=limit.least)
        keys[field.name] = (Annotated[float | None, reads], Field(None, description=limit.meaning))
    keys |= {also: (keys[name][0], Field(None, description=f"as {name}")) for also, name in ALSO.items()}
    return create_model("SheetTable", __base__=MotorTable, **keys)
