"""Pages of the reference that are tables: commands with their options, keys of a cell file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from docstrings import escaped, table

from holonom.app.cell.schema import cell_schema
from holonom.app.commands import COMMANDS
from holonom.app.console import options

UNITS = re.compile(r"\\s\*\(([^()]+)\)\\s\*\$$")


def commands() -> str:
    """Return the page of the commands."""
    lines = ["# Commands\n", COMMON]
    for name in COMMANDS.own:
        command = COMMANDS[name]
        parser = options._parser(options._fields(command.record), f"holonom {name}", command.help)
        usage = " ".join(parser.format_usage().removeprefix("usage: ").split())
        lines += [f"## holonom {name}\n", f"{escaped(command.help)}.\n", f"```text\n{usage}\n```\n"]
        lines.append(table([_option(action) for action in parser._actions], ["option", "value", "meaning"]))
    return "\n".join(lines)


COMMON = """`holonom --help` lists the commands, `holonom COMMAND --help` says what one takes. Exit status: 0 when the
question was answered; 2 for bad input, found before anything runs; 1 for what fails after the start; 130 for Ctrl-C.
"""


def _option(action: Any) -> list[str]:
    names = ", ".join(f"`{name}`" for name in action.option_strings) or f"`{action.metavar or action.dest}`"
    value = " ".join(action.metavar) if isinstance(action.metavar, tuple) else action.metavar or ""
    value = f"`{value}`" if value and action.option_strings else ""
    several = {"+": "one or more; ", "*": "any number; ", "?": "may be left out; "}.get(action.nargs or "", "")
    said = several + (action.help or "").replace("%%", "%")
    return [
        names,
        value.replace("|", "\\|"),
        escaped(said) + ("; required" if action.required and action.option_strings else ""),
    ]


def cell_keys() -> str:
    """Return the page of the keys of a cell file."""
    schema = cell_schema()
    used = _uses(schema)
    lines = ["# Keys of a cell file\n", CELL, _section("The file", "", schema, schema["properties"])]
    for name in sorted(schema["$defs"], key=lambda name: (not used[name][0].startswith("["), name)):
        found = schema["$defs"][name]
        said = f"{found.get('description', '')} `{name}` in the schema; it stands at {', '.join(used[name])}."
        title = used[name][0] if used[name][0].startswith("[") else name
        lines += [f"({name.lower()})=", _section(title, said, found, found["properties"])]
    return "\n".join(lines)


def _uses(schema: dict[str, Any]) -> dict[str, list[str]]:
    """Return where each table stands: `[cell]`, `[[robot]]`, else the keys that hold it."""
    found: dict[str, list[str]] = {name: [] for name in schema["$defs"]}
    for key, value in schema["properties"].items():
        for name in _named(value):
            found[name].append(f"[[{key}]]" if value.get("type") == "array" else f"[{key}]")
    for owner, table_ in schema["$defs"].items():
        for key, value in table_["properties"].items():
            for name in _named(value):
                found[name].append(f"`{key}` of `{owner}`")
    return found


def _named(schema: Any) -> Iterator[str]:
    """Yield the names of tables that a schema refers to."""
    if isinstance(schema, dict):
        if "$ref" in schema:
            yield schema["$ref"].rpartition("/")[2]
        for value in schema.values():
            yield from _named(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from _named(value)


CELL = """A cell file is TOML; [the chapter](../cell.md) says how its tables go together. Quantities are texts with a
unit (`"250mm/s"`); the column unit lists those that are taken. This page is made from the models that read the file, as
`holonom doctor --schema` is.
"""


def _section(title: str, said: str, owner: dict[str, Any], properties: dict[str, Any], level: int = 2) -> str:
    required = owner.get("required", ())
    rows = [[f"`{key}`", kind(p), units(p), _default(p, key in required), meaning(p)] for key, p in properties.items()]
    inner = [
        _section(_within(title, key, form), found.get("description", ""), found, found["properties"], 3)
        for key, p in properties.items()
        for form, found in _inline(p)
    ]
    head = f"{'#' * level} {escaped(title)}\n\n{escaped(said)}\n\n"
    return head + table(rows, ["key", "type", "unit", "default", "meaning"]) + "\n" + "\n".join(inner)


def _within(title: str, key: str, form: str) -> str:
    return f"[[{key}]]{form}" if title == "The file" else f"{key} of {title}{form}"


def _inline(schema: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield tables that are written out where they are used, with what tells them from the others."""
    if "properties" in schema:
        constants = [str(p["const"]) for p in schema["properties"].values() if "const" in p]
        yield (f", {constants[0]}" if constants else ""), schema
    for part in (*schema.get("anyOf", ()), *schema.get("oneOf", ()), *schema.get("prefixItems", ())):
        yield from _inline(part)
    if isinstance(schema.get("items"), dict):
        yield from _inline(schema["items"])


def kind(schema: dict[str, Any]) -> str:
    """Return the type of a value in words."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in schema:
        return f"`{schema['const']!r}`".replace("'", '"')
    if "enum" in schema:
        return " or ".join(f'`"{name}"`' for name in schema["enum"])
    parts = [*schema.get("anyOf", ()), *schema.get("oneOf", ())]
    if parts:
        words = [kind(part) for part in parts if part.get("type") != "null"]
        return " or ".join(dict.fromkeys(words))
    if schema.get("type") == "array":
        return _array(schema)
    if "pattern" in schema and units(schema):
        return "quantity"
    return {"string": "text", "integer": "whole number", "boolean": "true or false", "object": "table"}.get(
        schema.get("type", ""), schema.get("type", "any")
    )


def _array(schema: dict[str, Any]) -> str:
    if "prefixItems" in schema:
        words = [kind(part) for part in schema["prefixItems"]]
        return f"list of {len(words)}: {words[0]}" if len(set(words)) == 1 else f"list: {', '.join(words)}"
    return f"list of {kind(schema.get('items', {}))}"


def units(schema: dict[str, Any]) -> str:
    """Return the units that a quantity may have."""
    found = UNITS.search(schema.get("pattern", ""))
    if found:
        return ", ".join(found[1].split("|"))
    parts = [*schema.get("anyOf", ()), *schema.get("oneOf", ()), *schema.get("prefixItems", ())]
    parts += [schema["items"]] if isinstance(schema.get("items"), dict) else []
    return " or ".join(dict.fromkeys(filter(None, map(units, (p for p in parts if "properties" not in p)))))


def _default(schema: dict[str, Any], required: bool) -> str:
    if required:
        return "required"
    default = schema.get("default")
    return "" if default is None or default in ([], "") else f"`{default}`"


def meaning(schema: dict[str, Any]) -> str:
    """Return what a key means, and its range."""
    words = {
        "minimum": "at least",
        "exclusiveMinimum": "more than",
        "maximum": "at most",
        "exclusiveMaximum": "less than",
    }
    bounds = [f"{word} {schema[key]:g}" for key, word in words.items() if key in schema]
    return escaped("; ".join(filter(None, [schema.get("description", ""), ", ".join(bounds)])))
