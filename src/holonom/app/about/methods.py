"""Tables of methods in words: for a terminal, as JSON, as the page of the docs."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin

from holonom.app.about.tables import TABLES, table_of
from holonom.app.console.answer import Answer
from holonom.registry import Field, Method, Table

__all__ = ["kinds", "of_kind", "page"]


def kinds() -> Answer:
    """List the kinds of methods, with the names of each."""
    rows: list[dict[str, Any]] = []
    problems: list[str] = []
    for kind in TABLES:
        table = table_of(kind)
        found, wrong = table.survey()
        rows.append({"kind": kind, "one": table.one, "makes": table.product, "names": list(found)})
        problems += wrong
    lines: list[str] = []
    for row in rows:
        names = ", ".join(row["names"])
        lines += [row["kind"], textwrap.fill(names, 118, initial_indent=" " * 4, subsequent_indent=" " * 4)]
    lines += ["'holonom methods KIND' describes them", *(f"note: {problem}" for problem in problems)]
    return Answer("\n".join(lines), {"kinds": rows, "problems": problems})


def of_kind(kind: str) -> Answer:
    """List the methods of a kind with their parameters.

    Raises
    ------
    UnknownName
        No such kind.
    """
    table = table_of(kind)
    found, problems = table.survey()
    methods = [_data(name, method) for name, method in found.items()]
    data = {"kind": kind, "one": table.one, "makes": table.product, "methods": methods, "problems": list(problems)}
    lines = [line for method in methods for line in _lines(method)]
    return Answer("\n".join([*lines, *(f"note: {problem}" for problem in problems)]), data)


def page() -> Answer:
    """Return the page `docs/methods.md`: `holonom methods --markdown > docs/methods.md`."""
    tables = {kind: table_of(kind) for kind in TABLES}
    data = {kind: [_data(name, table[name]) for name in table.own] for kind, table in tables.items()}
    text = "\n".join([_HEAD, *(line for kind, rows in data.items() for line in _section(tables[kind], rows))])
    return Answer(text.rstrip(), {"page": text})


_HEAD = """# Methods

What there is to choose from, by kind. `holonom methods KIND` prints the same, with what other packages add. This page
is made from the tables: `holonom methods --markdown > docs/methods.md`.
"""


def _section(table: Table, methods: Sequence[Mapping[str, Any]]) -> list[str]:
    lines = [f"## {table.kind}", "", f"`make` gives {table.product}.", "", "| name | what | source |", "|---|---|---|"]
    lines += [f"| `{m['name']}` | {_cell(m['help'])} | {_cell(m['source'])} |" for m in methods]
    rows = [(m["name"], p) for m in methods for p in m["parameters"]]
    if rows:
        lines += ["", f"| {table.one} | parameter | unit | allowed | default | meaning |", "|---|---|---|---|---|---|"]
        lines += [
            f"| `{name}` | `{p['name']}` | {p['unit']} | {_cell(_allowed(p))} | {_cell(_default(p))} "
            f"| {_cell(p['meaning'])} |"
            for name, p in rows
        ]
    return [*lines, ""]


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*").replace("$", "\\$")


def _lines(method: Mapping[str, Any]) -> list[str]:
    lines = [f"{method['name']}: {method['help']}", f"    source: {method['source']}"]
    for p in method["parameters"]:
        unit = f" {p['unit']}" if p["unit"] else ""
        allowed = f" [{_allowed(p)}]" if _allowed(p) else ""
        lines.append(f"    {p['name']} = {_default(p)}{unit}{allowed}: {p['meaning']}")
    return lines


def _allowed(p: Mapping[str, Any]) -> str:
    return ", ".join(p["choices"]) if p["choices"] else p["range"] or p["type"]


def _default(p: Mapping[str, Any]) -> str:
    if p["required"]:
        return "(needed)"
    default = p["default"]
    if default is None or default == []:
        return "none"
    return f"{default:g}" if isinstance(default, float) else str(default)


def _data(name: str, method: Method) -> dict[str, Any]:
    return {
        "name": name,
        "help": method.help,
        "source": method.source,
        "parameters": [_parameter(field) for field in method.fields],
    }


def _parameter(field: Field) -> dict[str, Any]:
    stated = field.parameter
    bounds = {bound: getattr(stated, bound) for bound in ("least", "most", "above", "below")}
    return {
        "name": field.name,
        "type": _type(field.type),
        "unit": stated.unit,
        "range": stated.range,
        "bounds": {name: bound for name, bound in bounds.items() if bound is not None and math.isfinite(bound)},
        "choices": list(stated.names()),
        "required": field.required,
        "default": None if field.required else _value(field.default),
        "meaning": stated.meaning,
    }


def _type(kind: Any) -> str:
    """Return a field's type in words: "number", "2 numbers", "lists of 2 numbers", "number or numbers"."""
    if get_origin(kind) in (Union, UnionType):
        return " or ".join(_type(part) for part in get_args(kind) if part is not NoneType)
    if get_origin(kind) is not tuple:
        return _TYPES[kind]
    parts = get_args(kind)
    inner = f"lists of {_type(parts[0])}" if get_origin(parts[0]) is tuple else f"{_TYPES[parts[0]]}s"
    return inner if parts[-1] is Ellipsis else f"{len(parts)} {inner}"


def _value(value: Any) -> Any:
    """Return a default as a JSON value."""
    if isinstance(value, (tuple, list)):
        return [_value(entry) for entry in value]
    return "inf" if value == math.inf else value


_TYPES: Mapping[Any, str] = {float: "number", int: "whole number", bool: "switch", str: "text", Path: "path"}
