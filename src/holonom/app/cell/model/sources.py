"""What a robot is: `model` of a `[[robot]]`, read to an arm or to wheels under a body."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, Strict, TypeAdapter, ValidationInfo
from pydantic_core import core_schema

from holonom.app.cell.model.refusals import Faults, read_form, refuse
from holonom.app.fields.methods import params_schema, read_params
from holonom.app.fields.quantities import Angle, File, Length, OneOf, Quantity, Section, Size, Text, Vector2
from holonom.errors import CellError, InputError, ModelError, UnknownName
from holonom.mobile import Wheel, WheelBase
from holonom.mobile.base.wheel import KINDS
from holonom.mobile.methods import ARRANGEMENTS
from holonom.model import PRESETS, ArmModel, preset
from holonom.model.load import CHECKS, CheckMode, found_model

__all__ = ["ArmSource", "BaseSource", "BodyTable", "FileTable", "ReadModel", "WheelTable", "base_schema", "form_schema"]


@dataclass(frozen=True, slots=True)
class ArmSource:
    """An arm: what the cell calls it, its preset's name ("" for a file), and what it is."""

    name: str
    preset: str
    model: ArmModel


@dataclass(frozen=True, slots=True)
class BaseSource:
    """A mobile base: its arrangement ("" for wheels one by one), their params, and what it is."""

    arrangement: str
    params: Any
    base: WheelBase


class FileTable(Section):
    """A robot description."""

    file: File
    """URDF or xacro file, relative to the cell file"""
    root: Text | None = None
    """the link that is the base; the one that no joint carries unless given"""
    tip: Text | None = None
    """the link that is the tool; the one that is called like one, else a guess that is noted, unless given"""
    check: Annotated[str, OneOf(CHECKS)] = "warn"
    """what the file may leave out or say too much: "warn" notes what is taken instead, "strict" refuses it"""
    check_inertia: Annotated[bool, Strict()] = True
    """whether an inertia that no body has takes the dynamics away; false takes it as it is"""


class WheelTable(Section):
    """One wheel of a base; x forwards, y to the left."""

    kind: Annotated[str, OneOf(KINDS)]
    """what it may do"""
    x: Length
    """forwards of the base's origin; of a castor, its pivot"""
    y: Length
    """to the left of it"""
    heading: Angle = 0.0
    """direction in which it rolls, from x"""
    radius: Size
    """of the wheel"""
    roller_angle: Angle = 0.0
    """of a Swedish wheel: 0 for an omni wheel, 45 or -45 degrees for a mecanum wheel"""
    castor_offset: Length = 0.0
    """of a castor, its trail"""
    driven: Annotated[bool, Strict()] = False
    """whether a motor turns it"""
    max_steering: Angle | None = None
    """of a steered wheel, how far it turns to either side"""
    name: str = ""
    """what it is called"""


Moment = Annotated[float, Quantity("inertia", "0.001gcm2", "100000kgm2")]


class BodyTable(Section):
    """What a base is beside its arrangement."""

    wheels: Annotated[tuple[Text | WheelTable, ...], Field(min_length=1)] | None = None
    """names of the driven wheels of an arrangement, in their order; or, without one, the wheels as tables"""
    mass: Annotated[float, Quantity("mass", "1g", "5000kg")]
    """mass with wheels and motors"""
    mass_distribution: Annotated[float, Quantity("number", 0.01, 10.0)] = 0.5
    """alpha of the moment of inertia alpha M R2 about the centre of mass: 0.5 for a disc, 1 for a ring"""
    inertia: tuple[Moment, Moment, Moment] | None = None
    """instead of mass_distribution: moments of inertia about the centre of mass, about x, y and z"""
    com: Vector2 | None = None
    """centre of mass in base_link, forwards and to the left; unless stated, in the middle of its wheels"""
    height: Annotated[float, Quantity("length", "0mm", "5m")] = 0.0
    """height of the centre of mass; of a body that balances three wheel radii unless stated"""


_BODY = frozenset(BodyTable.model_fields)
_TAKES = "a preset's name, a .urdf or .xacro file, an arrangement of wheels, or a table of one of them"


@dataclass(frozen=True, slots=True)
class ReadModel:
    """Reads `model`, in whatever form it is stated."""

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.with_info_plain_validator_function(_read)

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        body = handler.resolve_ref_schema(form_schema(BodyTable, handler))["properties"]
        one = {"preset": {"enum": list(PRESETS), "type": "string", "description": "an arm that Holonom knows"}}
        return {
            "anyOf": [
                {"type": "string"},
                {"type": "object", "properties": one, "required": ["preset"], "additionalProperties": False},
                form_schema(FileTable, handler),
                *(base_schema(name, body) for name in ARRANGEMENTS),
                form_schema(BodyTable, handler),
            ]
        }


def form_schema(form: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """Return the JSON Schema of a form that a key may have, as a part of the cell's."""
    return handler(TypeAdapter(form).core_schema)


def base_schema(name: str, body: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON Schema of a base of an arrangement with the properties of its body."""
    found = params_schema(ARRANGEMENTS[name])
    own = {"arrangement": {"const": name, "description": "how the wheels stand"}}
    needed = ["arrangement", "mass", *found["required"]]
    return {**found, "properties": {**body, **own, **found["properties"]}, "required": needed}


def _read(given: object, info: ValidationInfo) -> ArmSource | BaseSource:
    if isinstance(given, str):
        return _named(given, info)
    if not isinstance(given, Mapping):
        raise CellError(f"{given!r} came; {_TAKES} is expected")
    for key, read in _FORMS.items():
        if key in given:
            return read(given, info)
    raise CellError(f"{', '.join(given) or 'nothing'} came; {_TAKES} is expected: {', '.join(_FORMS)}")


def _named(name: str, info: ValidationInfo) -> ArmSource | BaseSource:
    if Path(name).suffix.lower() in (".urdf", ".xacro", ".xml"):
        return _from_file({"file": name}, info)
    if name in PRESETS:
        return ArmSource(name, name, preset(name))
    if name in ARRANGEMENTS:
        return _arranged({"arrangement": name}, info)
    raise UnknownName("model", name, [*PRESETS, *ARRANGEMENTS])


def _preset(given: Mapping[str, Any], info: ValidationInfo) -> ArmSource:
    spare = [key for key in given if key != "preset"]
    if spare:
        raise refuse((spare[0],), UnknownName("key", spare[0], ["preset"]))
    try:
        return ArmSource(given["preset"], given["preset"], preset(given["preset"]))
    except (InputError, TypeError) as problem:
        raise refuse(("preset",), problem, given["preset"]) from None


def _from_file(given: Mapping[str, Any], info: ValidationInfo) -> ArmSource:
    table = read_form(FileTable, given, info.context)
    check: CheckMode = "strict" if table.check == "strict" else "warn"
    model = found_model(
        table.file, root=table.root, tip=table.tip, check=check, check_inertia=table.check_inertia
    )  # its notes are the cell's
    return ArmSource(table.file.name, "", model)


def _arranged(given: Mapping[str, Any], info: ValidationInfo) -> BaseSource:
    kind, faults = given["arrangement"], Faults()
    rest = {key: value for key, value in given.items() if key not in _BODY and key != "arrangement"}
    body = faults.call((), _body, given)
    known = faults.call(("arrangement",), _NAMES.validate_python, kind)
    params = faults.call((), read_params, ARRANGEMENTS, kind, rest) if known is not None else None
    faults.raise_any()
    made: WheelBase = ARRANGEMENTS[kind].build(params)
    return BaseSource(kind, params, _built(made, _renamed(made, body), body))


def _one_by_one(given: Mapping[str, Any], info: ValidationInfo) -> BaseSource:
    spare = [key for key in given if key not in _BODY]
    if spare:
        raise refuse((spare[0],), UnknownName("key", spare[0], [*_BODY, "arrangement"]))
    body = _body(given)
    wheels = []
    for table in body.wheels or ():
        if isinstance(table, str):
            raise refuse(("wheels",), f"{table!r} came; names need an arrangement, or give each wheel as a table")
        wheels.append(Wheel.at(**table.model_dump()))
    return BaseSource("", None, WheelBase(
        wheels, name="base", alpha=body.mass_distribution, mass=body.mass, com=_com(body, wheels),
        com_height=body.height, inertia=body.inertia,
    ))  # fmt: skip


def _body(given: Mapping[str, Any]) -> BodyTable:
    """The body's keys; wheels that are all tables or all names are read as such, so that faults name their keys."""
    own = {key: value for key, value in given.items() if key in _BODY and key != "wheels"}
    faults = Faults()
    body = faults.call((), read_form, BodyTable, own)
    wheels = faults.call(("wheels",), _wheels, given.get("wheels"))
    faults.raise_any()
    found: BodyTable = body.model_copy(update={"wheels": wheels})
    return found


def _wheels(given: object) -> tuple[str | WheelTable, ...] | None:
    if given is None:
        return None
    if not isinstance(given, list | tuple) or not any(isinstance(entry, Mapping) for entry in given):
        return _WORDS.validate_python(given)
    faults = Faults()
    found = [faults.call((number,), read_form, WheelTable, entry) for number, entry in enumerate(given)]
    faults.raise_any()
    return tuple(found)


_NAMES: TypeAdapter[str] = TypeAdapter(Annotated[str, OneOf(ARRANGEMENTS)])
_WORDS: TypeAdapter[tuple[str, ...]] = TypeAdapter(tuple[Text, ...])


def _renamed(made: WheelBase, body: BodyTable) -> list[Wheel]:
    """The wheels, the driven ones by the names that the cell gives them."""
    driven = [wheel for wheel in made.wheels if wheel.driven]
    names = list(body.wheels) if body.wheels is not None else [wheel.name for wheel in driven]
    if len(names) != len(driven) or len(set(names)) != len(driven):
        raise refuse(
            ("wheels",), f"{len(names)} names of wheels came; {len(driven)} different ones are needed", list(names)
        )
    left = iter(names)
    return [dataclasses.replace(wheel, name=str(next(left))) if wheel.driven else wheel for wheel in made.wheels]


def _com(body: BodyTable, wheels: Sequence[Wheel]) -> tuple[float, float]:
    """The centre of mass; where none is stated, the mean of the wheels' places, so that the base stands."""
    if body.com is not None:
        return body.com
    x, y = (sum(values) / len(wheels) for values in zip(*((w.x, w.y) for w in wheels), strict=True))
    return (0.0 if abs(x) < 1e-12 else x), (0.0 if abs(y) < 1e-12 else y)


def _built(made: WheelBase, wheels: list[Wheel], body: BodyTable) -> WheelBase:
    groups = {
        name: [wheels[i].name for i in group] for name, group in zip(made.steered, made.layout.groups, strict=True)
    }
    shared = {name: group for name, group in groups.items() if len(group) > 1}
    height = made.com_height if made.balances and "height" not in body.model_fields_set else body.height
    base = WheelBase(
        wheels, name=made.name, radius=made.radius, alpha=body.mass_distribution, mass=body.mass,
        com=_com(body, wheels), com_height=height, inertia=body.inertia, steering_groups=shared,
        suspension=made.suspension, balances=made.balances,
    )  # fmt: skip
    rollers = all(wheel.kind == "swedish" for wheel in wheels)
    if rollers and np.linalg.matrix_rank(base.velocity_coupling, tol=1e-6) < 3:
        raise ModelError(
            "the wheels cannot drive this base in all directions and turn it; spread the motor axes' angles"
        )
    return base


_FORMS: Mapping[str, Callable[[Mapping[str, Any], ValidationInfo], ArmSource | BaseSource]] = {
    "preset": _preset,
    "file": _from_file,
    "arrangement": _arranged,
    "wheels": _one_by_one,
}
"""What a table `model` may be of, by the key that it has."""
