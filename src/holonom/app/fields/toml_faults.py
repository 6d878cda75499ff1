"""Faults of a TOML file that a pydantic model describes, worded for people: file, line, key, what came, what to do."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from holonom.app.console.printable import one_line
from holonom.app.fields.toml_lines import KeyPath, check_bounds, key_lines
from holonom.errors import InputError, UnknownName
from holonom.files import NESTING

__all__ = ["MOST", "explained", "line_of", "parse_toml", "worded_faults", "written_key"]

MOST = 20
"""Faults of one file that are told; of more their number."""
_EXPECTED = {
    "int_type": "a whole number is expected",
    "model_type": "a table is expected",
    "string_pattern_mismatch": "another form is expected",
    "string_too_short": "text is expected",
    "string_type": "text in quotes is expected",
    "tuple_type": "a list in brackets is expected",
}


def parse_toml(path: Path, text: str, problem: type[InputError], example: str = 'length = "120mm"') -> dict[str, Any]:
    """Parse TOML.

    Parameters
    ----------
    path : of the file, for messages.
    text : what it holds.
    problem : error to raise.
    example : of a line that such a file has.

    Raises
    ------
    InputError
        Of the type `problem`: file, line and column of what is no TOML.
    """
    check_bounds(path, text, problem)
    try:
        return tomllib.loads(text)
    except RecursionError:  # of what the scan of valid text did not count
        raise problem(
            f"{path}:1: nested too deeply; at most {NESTING} tables and lists in each other are read"
        ) from None
    except tomllib.TOMLDecodeError as error:
        message = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
        what, line, column = message.groups() if message else (str(error), None, None)
        place = f"{line}:{column}" if line else str(max(1, len(text.splitlines())))
        raise problem(
            f"{path}:{place}: not TOML: {what}; expected [table] headers and lines such as {example}"
        ) from None


def worded_faults(
    path: Path,
    text: str,
    model: type[BaseModel],
    faults: Sequence[ErrorDetails],
    *,
    place: Callable[[KeyPath], KeyPath] = lambda at: at,
    also: Mapping[KeyPath, Sequence[str]] = MappingProxyType({}),
) -> str:
    """Word what a model found wrong in a TOML file: a line for each fault with file, line, key, and what to do.

    Parameters
    ----------
    path, text : of the file.
    model : that was validated, with a docstring for each field.
    faults : `ValidationError.errors()`.
    place : path of a key in the file from that in the model.
    also : keys that a table of the file may have beside those of the model.
    """
    lines = key_lines(text)
    within = {tuple(fault["loc"][:k]) for fault in faults for k in range(len(fault["loc"]))}
    told = [fault for fault in faults if not (fault["type"] == "too_short" and tuple(fault["loc"]) in within)]
    placed = [(place(tuple(fault["loc"])), fault) for fault in told]
    located = sorted(((line_of(at, lines), written_key(at), fault) for at, fault in placed), key=lambda one: one[:2])
    worded = [f"{path}:{line}: {key}: {explained(model, fault, also)}" for line, key, fault in located[:MOST]]
    more = [f"{path}: and {len(located) - MOST} more faults"] if len(located) > MOST else []
    return "\n".join(worded + more)


def line_of(loc: KeyPath, lines: Mapping[KeyPath, int]) -> int:
    """Line of a key, or of the innermost table around it that is there."""
    return next((lines[loc[:k]] for k in range(len(loc), 0, -1) if loc[:k] in lines), 1)


def written_key(loc: KeyPath) -> str:
    """Write a path as "camera.points[2].table"."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{one_line(part)}" for part in loc).removeprefix(".")


def explained(
    model: type[BaseModel], fault: ErrorDetails, also: Mapping[KeyPath, Sequence[str]] = MappingProxyType({})
) -> str:
    """Say what came, what is expected and what to do; arguments as for `worded_faults`."""
    context, came = fault.get("ctx", {}), fault["input"]
    match fault["type"]:
        case "value_error":
            return _shortened(str(context["error"]), 1000)
        case "extra_forbidden":
            table = tuple(fault["loc"][:-1])
            keys = [*_model_at(model, table).model_fields, *also.get(table, ())]
            return str(UnknownName("key", str(fault["loc"][-1]), keys))
        case "missing":
            return f"missing; expected: {_description(model, fault['loc'])}"
        case "literal_error":
            return str(UnknownName("setting", str(came)[:200], re.findall(r"'(.*?)'", context["expected"])))
        case "too_short":
            came, least = context["actual_length"], context["min_length"]
            return f"{came} came; at least {least} are needed: {_description(model, fault['loc'])}"
        case "too_long":
            came, most = context["actual_length"], context["max_length"]
            return f"{came} came; {most} are allowed: {_description(model, fault['loc'])}"
        case kind:
            expected = _EXPECTED.get(kind) or fault["msg"].replace("Input", "it", 1)
            means = _description(model, fault["loc"])
            return f"{_shown(came)} came; {expected}" + (f": {means}" if means else "")


def _shown(came: object) -> str:
    return _shortened(repr(came), 200)


def _shortened(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 2]} ... {text[-most // 2 :]}"


def _description(model: type[BaseModel], loc: KeyPath) -> str:
    """What the schema says about the innermost key of a path."""
    description = ""
    for part in (part for part in loc if isinstance(part, str)):
        field = model.model_fields.get(part)
        if field is None:  # a key of a table of any keys
            break
        description = field.description or ""
        model = _model_in(field.annotation) or model
    return description


def _model_at(model: type[BaseModel], loc: KeyPath) -> type[BaseModel]:
    """The model of the table that a path leads to."""
    for part in loc:
        if isinstance(part, str) and part in model.model_fields:
            model = _model_in(model.model_fields[part].annotation) or model
    return model


def _model_in(annotation: object) -> type[BaseModel] | None:
    """The model in an annotation such as `tuple[Model, ...] | None`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for found in map(_model_in, get_args(annotation)) if found is not None), None)
