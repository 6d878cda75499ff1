"""Reading a cell file: TOML to a checked `Cell`, or one error that names file, line and key of all that is wrong."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from holonom.app.arm.cell_model import ArmCell
from holonom.app.base.cell_model import BaseCell
from holonom.app.toml_lines import KeyPath, key_lines
from holonom.errors import CellError, UnknownName

__all__ = ["ArmCell", "BaseCell", "cell_schema", "load_cell"]

KINDS: dict[str, type[ArmCell] | type[BaseCell]] = {"arm": ArmCell, "base": BaseCell}
"""What a cell is of, by the table that every cell file has one of."""

_EXPECTED = {
    "int_type": "a whole number is expected",
    "model_type": "a table is expected",
    "string_pattern_mismatch": "another form is expected",
    "string_too_short": "text is expected",
    "string_type": "text in quotes is expected",
    "tuple_type": "a list in brackets is expected",
}


def load_cell(path: str | Path) -> ArmCell | BaseCell:
    """Read and check a cell file.

    Parameters
    ----------
    path : the TOML file; the files that it names are relative to its folder.

    Returns
    -------
    The cell, in SI units and radians, with files as paths that exist.

    Raises
    ------
    CellError
        One line for each fault: file, line, key, what came, what is expected.
    """
    path = Path(path)
    text = _read(path)
    data = _parse(path, text)
    model = _kind(path, data)
    try:
        return model.model_validate(data, context={"folder": path.parent})
    except ValidationError as error:
        raise CellError(_faults(path, text, model, error.errors(include_url=False))) from None


def cell_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of cell files; `holonom doctor --schema` prints it."""
    schema = TypeAdapter(ArmCell | BaseCell).json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Holonom cell file"}


def _kind(path: Path, data: Mapping[str, Any]) -> type[ArmCell] | type[BaseCell]:
    named = [name for name in KINDS if name in data]
    if len(named) == 2:
        raise CellError(f"{path}:1: tables [arm] and [base] came; a cell has one of them, give the other its own file")
    return KINDS[named[0]] if named else ArmCell


def _read(path: Path) -> str:
    try:
        raw = path.read_bytes()
        return raw.decode("utf-8")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise CellError(f"{path}:{line}: not UTF-8 text, so no TOML; save the file as UTF-8") from None
    except OSError as error:
        raise CellError(f"{path}: {error.strerror}; give the path of a cell file (TOML)") from None


def _parse(path: Path, text: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        what, line, column = message.groups() if message else (str(error), None, None)
        place = f"{line}:{column}" if line else str(max(1, len(text.splitlines())))
        raise CellError(
            f'{path}:{place}: not TOML: {what}; expected [table] headers and lines such as length = "120mm"'
        ) from None


def _faults(path: Path, text: str, model: type[BaseModel], faults: Sequence[ErrorDetails]) -> str:
    lines = key_lines(text)
    told = [fault for fault in faults if not _follows(fault, faults)]
    located = sorted((_line(fault["loc"], lines), _key(fault["loc"]), _explain(model, fault)) for fault in told)
    return "\n".join(f"{path}:{line}: {key}: {explanation}" for line, key, explanation in located)


def _follows(fault: ErrorDetails, faults: Sequence[ErrorDetails]) -> bool:
    """A list that is too short only because one of its elements is at fault itself."""
    loc = fault["loc"]
    return fault["type"] == "too_short" and any(
        other["loc"][: len(loc)] == loc and other is not fault for other in faults
    )


def _line(loc: KeyPath, lines: Mapping[KeyPath, int]) -> int:
    """Line of a key, or of the innermost table around it that is there."""
    return next((lines[loc[:k]] for k in range(len(loc), 0, -1) if loc[:k] in lines), 1)


def _key(loc: KeyPath) -> str:
    """Write a path as "camera.points[2].table"."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc).removeprefix(".")


def _explain(model: type[BaseModel], fault: ErrorDetails) -> str:
    """Say what came, what is expected and what to do."""
    context, came = fault.get("ctx", {}), fault["input"]
    match fault["type"]:
        case "value_error":
            return str(context["error"])
        case "extra_forbidden":
            return str(
                UnknownName("key", str(fault["loc"][-1]), list(_model_at(model, fault["loc"][:-1]).model_fields))
            )
        case "missing":
            return f"missing; expected: {_description(model, fault['loc'])}"
        case "literal_error":
            return str(UnknownName("setting", str(came), re.findall(r"'(.*?)'", context["expected"])))
        case "too_short":
            came, least = context["actual_length"], context["min_length"]
            return f"{came} came; at least {least} are needed: {_description(model, fault['loc'])}"
        case "too_long":
            came, most = context["actual_length"], context["max_length"]
            return f"{came} came; {most} are allowed: {_description(model, fault['loc'])}"
        case kind:
            expected = _EXPECTED.get(kind) or fault["msg"].replace("Input", "it", 1)
            return f"{came!r} came; {expected}: {_description(model, fault['loc'])}"


def _description(model: type[BaseModel], loc: KeyPath) -> str:
    """What the schema says about the innermost key of a path."""
    keys = [number for number, part in enumerate(loc) if isinstance(part, str)]
    field = _model_at(model, loc[: keys[-1]]).model_fields[str(loc[keys[-1]])]
    return field.description or ""


def _model_at(model: type[BaseModel], loc: KeyPath) -> type[BaseModel]:
    """The model of the table that a path leads to."""
    for part in loc:
        if isinstance(part, str):
            model = _model_in(model.model_fields[part].annotation) or model
    return model


def _model_in(annotation: object) -> type[BaseModel] | None:
    """The model in an annotation such as `tuple[Model, ...] | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for found in map(_model_in, get_args(annotation)) if found is not None), None)
