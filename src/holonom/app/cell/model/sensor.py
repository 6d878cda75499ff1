"""`[[sensor]]`: a method of the table of sensors, on which robot, and what it is called."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic_core import core_schema

from holonom.app.cell.model.refusals import Faults, refuse
from holonom.app.fields.methods import Chosen, OneMethod
from holonom.app.fields.quantities import Text
from holonom.errors import CellError
from holonom.sim import SENSORS

__all__ = ["ReadSensor", "Sensor"]

_TEXT: TypeAdapter[str] = TypeAdapter(Text)
_READ = OneMethod(SENSORS)
_OWN = ("robot", "name")


@dataclass(frozen=True, slots=True)
class Sensor:
    """A sensor: the method with its params, the robot it is on (None: the only one), its name."""

    method: Chosen
    robot: str | None
    name: str


@dataclass(frozen=True, slots=True)
class ReadSensor:
    """Reads a `[[sensor]]`."""

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(_read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        own = {
            "robot": {"type": "string", "description": "robot that it is on; needed where there are several"},
            "name": {"type": "string", "description": "what it is called; its kind unless given"},
        }
        forms = _READ.__get_pydantic_json_schema__(schema, handler)["oneOf"][1:]
        return {"oneOf": [{**form, "properties": {**form["properties"], **own}} for form in forms]}


def _read(given: object) -> Sensor:
    if not isinstance(given, Mapping):
        raise CellError(f"{given!r} came; a table is expected: kind, and its parameters")
    if not isinstance(given.get("kind"), str):
        raise refuse(("kind",), f"missing; one of {', '.join(SENSORS)} is expected", given.get("kind"))
    faults = Faults()
    rest = {key: value for key, value in given.items() if key not in _OWN}
    method = faults.call((), _READ.read, rest)
    robot, name = (faults.call((key,), _TEXT.validate_python, given[key]) if key in given else None for key in _OWN)
    faults.raise_any()
    return Sensor(method, robot, name or method.name)
