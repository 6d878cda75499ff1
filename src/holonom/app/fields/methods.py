"""A method as a cell file chooses it: `{ kind = "gyro", noise = "0.1deg/s" }`, its parameters with their units.

=================  ==========================================================================
`OneMethod`        type of a key of a cell: `Annotated[Chosen, OneMethod(SENSORS)]`
`Chosen`           what it reads: the name, and the params record in SI
`read_params`      parameters of a method whose name stands elsewhere
`params_schema`    their JSON Schema
=================  ==========================================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from types import NoneType
from typing import Any, get_args, get_origin

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError, core_schema

from holonom.app.fields.units import DIMENSIONS, parse_quantity
from holonom.errors import CellError, InputError, OutOfLimits
from holonom.registry import Field, Method, Table, check_value

__all__ = ["Chosen", "OneMethod", "params_schema", "read_params"]

_TEXT = r"^\s*[+-]?(\d+(?:\.\d*)?|\.\d+)([eE][+-]?\d+)?\s*({units})\s*$"


@dataclass(frozen=True, slots=True)
class Chosen:
    """A method of a table by name, with its params record."""

    table: Table
    name: str
    params: Any

    def make(self) -> Any:
        """Return what the method makes of its params."""
        return self.table[self.name].build(self.params)


@dataclass(frozen=True, slots=True)
class OneMethod:
    """Reads a table with `kind` and the parameters of that method, or its name alone."""

    table: Table

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        forms = [self._form(name) for name in self.table]
        return {"oneOf": [{"enum": list(self.table), "type": "string"}, *forms]}

    def _form(self, name: str) -> dict[str, Any]:
        found = params_schema(self.table[name])
        return {
            **found,
            "properties": {"kind": {"const": name}, **found["properties"]},
            "required": ["kind", *found["required"]],
        }

    def read(self, value: object) -> Chosen:
        """Return what a value of a cell says."""
        given = {"kind": value} if isinstance(value, str) else value
        if not isinstance(given, Mapping) or not isinstance(given.get("kind"), str):
            names = ", ".join(self.table)
            raise CellError(
                f"{value!r} came; a {self.table.one} is expected: kind = one of {names}, and its parameters"
            )
        name = given["kind"]
        if isinstance(value, str):
            self.table[name]  # UnknownName
        elif name not in self.table:
            _refuse({"kind": _caught(lambda: self.table[name])}, given)
        rest = {key: entry for key, entry in given.items() if key != "kind"}
        return Chosen(self.table, name, read_params(self.table, name, rest))


def read_params(table: Table, name: str, given: Mapping[str, Any]) -> Any:
    """Return the params record of a method from the values of a cell file.

    Parameters
    ----------
    given : by name; what has a unit that cells know as text with one ("0.1deg/s"), the rest as it is.

    Raises
    ------
    ValidationError
        Of pydantic, an entry per key that is wrong, so that a cell's faults name file, line and key.
    InputError
        No such method; parameters that are missing or do not fit together.
    """
    fields = {field.name: field for field in table[name].fields}
    values: dict[str, Any] = {}
    wrong: dict[str, InputError] = {}
    for key, value in given.items():
        try:
            if key in fields:
                values[key] = check_value(key, _in_si(value, fields[key].type, fields[key]), fields[key])
            else:
                table.params(name, {key: value})  # which says what there is instead
        except InputError as problem:
            wrong[key] = problem
    if wrong:
        _refuse(wrong, given)
    return table.params(name, values)


def params_schema(method: Method) -> dict[str, Any]:
    """Return the JSON Schema (an object) of a method's parameters as a cell file states them."""
    return {
        "type": "object",
        "description": method.help,
        "properties": {field.name: _property(field) for field in method.fields},
        "required": [field.name for field in method.fields if field.required],
        "additionalProperties": False,
    }


LONGEST = 1000.0
"""m, of any length of a method's parameters."""


def _dimension(unit: str) -> str | None:
    """Return the dimension whose SI unit this is, None for plain numbers and what cells have no unit of."""
    written = unit.replace(" ", "")
    return next((d for d, units in DIMENSIONS.items() if written and units.get(written) == 1.0), None)


def _in_si(value: Any, kind: Any, field: Field) -> Any:
    """Return a value with every text in it that is to be a number read as a quantity."""
    dimension = _dimension(field.parameter.unit)
    if isinstance(value, (list, tuple)):
        return tuple(_in_si(entry, kind, field) for entry in value)
    if dimension is None or not _numbers(kind):
        return value
    number = parse_quantity(value, dimension)
    if dimension == "length" and abs(number) > LONGEST:
        raise OutOfLimits(f"{value!r} came; lengths up to {LONGEST:g} m are allowed")
    return number


def _numbers(kind: Any) -> bool:
    return kind is float or any(_numbers(part) for part in get_args(kind))


def _property(field: Field) -> dict[str, Any]:
    return {**_form(field.type, field), "description": field.parameter.meaning}


def _form(kind: Any, field: Field) -> dict[str, Any]:
    stated = field.parameter
    if get_origin(kind) is tuple:
        parts = get_args(kind)
        count = {} if parts[-1] is Ellipsis else {"minItems": len(parts), "maxItems": len(parts)}
        return {"type": "array", "items": _form(parts[0], field), **count}
    some = [part for part in get_args(kind) if part is not NoneType]
    if some:
        return _form(some[0], field) if len(some) == 1 else {"anyOf": [_form(part, field) for part in some]}
    dimension = _dimension(stated.unit)
    if kind is float and dimension is not None:
        return {"type": "string", "pattern": _TEXT.format(units="|".join(DIMENSIONS[dimension]))}
    if stated.choices is not None:
        return {"type": "string", "enum": list(stated.names())}
    bounds = zip(_BOUNDS, (stated.least, stated.most, stated.above, stated.below), strict=True)
    return {"type": _TYPES[kind], **{word: bound for word, bound in bounds if bound is not None and isfinite(bound)}}


_TYPES: Mapping[Any, str] = {float: "number", int: "integer", bool: "boolean", str: "string"}
_BOUNDS = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")


def _caught(call: Any) -> InputError:
    try:
        call()
    except InputError as problem:
        return problem
    raise AssertionError("it was to be refused")


def _refuse(wrong: Mapping[str, InputError], given: Mapping[str, Any]) -> None:
    details = [
        InitErrorDetails(
            type=PydanticCustomError("value_error", "{error}", {"error": str(problem)}), loc=(key,), input=given[key]
        )
        for key, problem in wrong.items()
    ]
    raise ValidationError.from_exception_data("method", details)
