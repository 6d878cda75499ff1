"""Fields of a params record: what each may hold, and how named values become a record."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import MISSING, dataclass
from functools import cache
from importlib import import_module
from numbers import Integral, Real
from types import MappingProxyType, NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from holonom.errors import InputError, OutOfLimits, UnknownName

__all__ = [
    "Field",
    "Parameter",
    "check_fields",
    "check_value",
    "imported",
    "parameter",
    "parameters_of",
    "read_record",
]

_KEY = "holonom.parameter"
R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a field of a record may hold, in SI.

    Attributes
    ----------
    meaning
        One line.
    unit
        Its symbol, empty for numbers without one and for names.
    least, most
        Allowed range, ends included. A number must be finite unless the bound on its side is infinite itself.
    above, below
        The same, ends excluded.
    choices
        Names that are allowed: themselves, or the import path ("module:TABLE") of what lists them.
    example
        A value for tests and docs where there is no default.
    """

    meaning: str
    unit: str = ""
    least: float | None = None
    most: float | None = None
    above: float | None = None
    below: float | None = None
    choices: Iterable[str] | str | None = None
    example: Any = None

    def names(self) -> tuple[str, ...]:
        """Return the names that are allowed, none where any is."""
        choices = imported(self.choices) if isinstance(self.choices, str) else self.choices
        return tuple(choices or ())

    @property
    def range(self) -> str:
        """The allowed numbers in words, empty where all finite ones are."""
        if self.least is not None and self.most is not None and math.isfinite(self.least) and math.isfinite(self.most):
            return f"{_shown(self.least)} to {_shown(self.most)}"
        words = {"at least": self.least, "greater than": self.above, "at most": self.most, "less than": self.below}
        finite = {word: bound for word, bound in words.items() if bound is not None and abs(bound) < math.inf}
        stated = [f"{word} {_shown(bound)}" for word, bound in finite.items()]
        return " and ".join([*stated, "may be infinite"] if self.infinite else stated)

    @property
    def allowed(self) -> str:
        """The range with its unit, as a message says it."""
        finite = "" if self.infinite or " to " in self.range else "finite"
        words = " and ".join(filter(None, (finite, self.range)))
        return f"{words} {self.unit}".rstrip()

    @property
    def infinite(self) -> bool:
        """Whether an infinite number is allowed."""
        return any(bound is not None and math.isinf(bound) for bound in (self.least, self.most))

    def allows(self, value: float) -> bool:
        """Whether a number lies in the range; NaN never does."""
        if math.isinf(value):
            return value in (self.least, self.most)
        return (
            not math.isnan(value)
            and (self.least is None or value >= self.least)
            and (self.most is None or value <= self.most)
            and (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
        )


@dataclass(frozen=True, slots=True)
class Field:
    """A parameter of a record: its name, type and default; `default` is `MISSING` where it must be given."""

    name: str
    type: Any
    default: Any
    parameter: Parameter

    @property
    def required(self) -> bool:
        """Whether it must be given."""
        return self.default is MISSING


def parameter(
    default: Any = MISSING,
    *,
    meaning: str,
    unit: str = "",
    least: float | None = None,
    most: float | None = None,
    above: float | None = None,
    below: float | None = None,
    choices: Iterable[str] | str | None = None,
    example: Any = None,
    extra: Mapping[str, Any] = MappingProxyType({}),
) -> Any:
    """Return a dataclass field that says what it may hold; arguments as `Parameter` describes them.

    `extra` joins the field's metadata: how an option is written on the command line.
    """
    limit = Parameter(meaning, unit, least, most, above, below, choices, example)
    return dataclasses.field(default=default, metadata={_KEY: limit, **extra})


def parameters_of(record: type[Any]) -> tuple[Field, ...]:
    """Return the fields of a record that were made by `parameter`, in their order."""
    unchecked: Any = record  # a type is hashable, which its annotation does not say
    return _fields_of(unchecked)


@cache
def _fields_of(record: Any) -> tuple[Field, ...]:
    types = get_type_hints(record)
    return tuple(
        Field(f.name, types[f.name], f.default, f.metadata[_KEY])
        for f in dataclasses.fields(record)
        if _KEY in f.metadata
    )


def check_fields(record: Any, error: type[InputError] | None = None) -> None:
    """Check every field of a record, for its `__post_init__`.

    Raises
    ------
    InputError
        A value of another type, a name that is not among the choices, a number outside its range; an `error` instead
        where one is given.
    """
    for field in parameters_of(type(record)):
        try:
            check_value(f"{type(record).__name__}: {field.name}", getattr(record, field.name), field)
        except InputError as problem:
            raise problem if error is None else error(str(problem)) from None


def read_record(record: type[R], given: Mapping[str, Any], what: str) -> R:
    """Make a record of named values.

    Parameters
    ----------
    record : a dataclass whose fields are made by `parameter`.
    given : values in SI by name.
    what : whose parameters they are, for the message: "controller 'cascade'".

    Raises
    ------
    UnknownName
        A name that is no parameter.
    InputError
        One that is missing, a value of another type.
    OutOfLimits
        A number outside its range, or NaN.
    """
    fields = {field.name: field for field in parameters_of(record)}
    for name in given:
        if name not in fields:
            if not fields:
                raise UnknownName(f"parameter of {what}", name, ["none"])
            raise UnknownName(f"parameter of {what}", name, fields)
    values = {name: check_value(f"{what}: {name}", value, fields[name]) for name, value in given.items()}
    missing = [name for name, field in fields.items() if field.required and name not in given]
    if missing:
        raise InputError(f"{what}: {', '.join(missing)} missing; it needs {_needed(fields.values())}")
    return record(**values)


def check_value(what: str, value: Any, field: Field) -> Any:
    """Return a value as the field's type: whole numbers as floats where floats are asked, lists as tuples.

    Raises
    ------
    InputError, UnknownName, OutOfLimits
    """
    return _checked(what, value, field.type, field.parameter)


def _checked(what: str, value: Any, kind: Any, limit: Parameter) -> Any:
    if get_origin(kind) in (Union, UnionType):
        if value is None and NoneType in get_args(kind):
            return None
        kind = _part(get_args(kind), value)
    if get_origin(kind) is tuple:
        return _tuple(what, value, get_args(kind), limit)
    if kind is float and isinstance(value, Real) and not isinstance(value, bool):
        value = float(value)
    wanted: Any = Integral if kind is int else kind
    if not isinstance(value, wanted) or (kind is int and isinstance(value, bool)):
        raise InputError(f"{what} is {value!r}; it must be {_WORDS.get(kind, f'a {kind.__name__}')}{_within(limit)}")
    if isinstance(value, str) and limit.choices is not None and value not in limit.names():
        raise UnknownName(f"value of {what}", value, limit.names())
    if kind in (int, float) and not limit.allows(value):
        raise OutOfLimits(f"{what} is {value!r}; it must be {limit.allowed}")
    return value


def _part(kinds: tuple[Any, ...], value: Any) -> Any:
    """Return the type of a union that a value is to be of: that of a list for lists, else the first."""
    listed = isinstance(value, (list, tuple))
    fitting = [part for part in kinds if part is not NoneType and (get_origin(part) is tuple) == listed]
    return fitting[0] if fitting else next(part for part in kinds if part is not NoneType)


def _tuple(what: str, value: Any, kinds: tuple[Any, ...], limit: Parameter) -> tuple[Any, ...]:
    if not isinstance(value, (list, tuple)):
        raise InputError(f"{what} is {value!r}; it must be a list")
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(value) != len(kinds):
        raise InputError(f"{what} has {len(value)} entries; {len(kinds)} are needed")
    return tuple(_checked(what, entry, kind, limit) for entry, kind in zip(value, kinds, strict=True))


_WORDS = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}


def _within(limit: Parameter) -> str:
    return f" {limit.range}" if limit.range else ""


def _shown(bound: float) -> str:
    return f"{bound:,}" if isinstance(bound, int) else f"{bound:g}"


def _needed(fields: Iterable[Field]) -> str:
    return ", ".join(f"{f.name} ({f.parameter.meaning})" for f in fields if f.required)


def imported(path: str) -> Any:
    """Return what an import path "module:name" names."""
    module, _, name = path.partition(":")
    return getattr(import_module(module), name)
