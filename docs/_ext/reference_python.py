"""Pages of the Python reference, from `__all__`, signatures and docstrings."""

from __future__ import annotations

import ast
import dataclasses
import enum
import importlib
import inspect
import re
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, UnionType
from typing import Any, get_args

from docstrings import escaped, markdown, table

import holonom
from holonom.registry import Parameter, Table

IMPORT = re.compile(r"^\s*from (holonom[\w.]*) import ([\w, ]+)", re.M)
DOCS = Path(__file__).resolve().parents[1]


@cache
def public() -> dict[str, tuple[str, ...]]:
    """Return the public names of each public module: what `holonom` lists, recursively, and what the pages import."""
    return dict(sorted((listed() | _walk(imported_on_pages())).items()))


@cache
def listed() -> dict[str, tuple[str, ...]]:
    """Return those that can be reached from `holonom`: `hm.mobile.poses`."""
    return _walk(["holonom", *(f"holonom.{name}" for name in holonom._SUBPACKAGES)])


def _walk(waiting: list[str]) -> dict[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    while waiting:
        module = importlib.import_module(waiting.pop(0))
        if module.__name__ in found or not hasattr(module, "__all__"):
            continue
        found[module.__name__] = tuple(module.__all__)
        values = [getattr(module, name) for name in module.__all__]
        waiting += [value.__name__ for value in values if isinstance(value, ModuleType)]
    return found


def imported_on_pages() -> list[str]:
    """Return the modules that README and docs import."""
    pages = [DOCS.parent / "README.md", *sorted(DOCS.rglob("*.md"))]
    texts = [
        page.read_text("utf-8")
        for page in pages
        if not {"_build", "reference"} & set(page.relative_to(DOCS.parent).parts)
    ]
    found = set()
    for module, names in (match for text in texts for match in IMPORT.findall(text)):
        found |= {
            module,
            *(f"{module}.{name}" for name in map(str.strip, names.split(",")) if _is_module(module, name)),
        }
    return sorted(found)


def _is_module(package: str, name: str) -> bool:
    value = getattr(importlib.import_module(package), name, None)
    return isinstance(value, ModuleType) or (value is None and find_spec(f"{package}.{name}") is not None)


def home(value: Any, name: str) -> str:
    """Return the public module in which a name has its entry: of those that `holonom` lists the nearest to its text."""
    having = [
        m for m, names in public().items() if name in names and getattr(importlib.import_module(m), name) is value
    ]
    having = [module for module in having if module in listed()] or having
    written = f"{getattr(value, '__module__', None)}."
    fitting = [module for module in having if written.startswith(f"{module}.")]
    return max(fitting or having, key=lambda module: (module.count("."), module))


def pages() -> dict[str, str]:
    """Return each module's page as Markdown."""
    return {module: page(module) for module in public()}


def page(module: str) -> str:
    """Return the page of a module."""
    package = importlib.import_module(module)
    intro = [f"# {module}\n", f"```{{py:module}} {module}\n```\n", markdown(inspect.getdoc(package) or "")]
    entries, elsewhere = [], []
    for name in public()[module]:
        value = getattr(package, name)
        if isinstance(value, ModuleType):
            elsewhere.append(f"- {{py:mod}}`{name} <{value.__name__}>`: {escaped(summary(value))}")
        elif (place := home(value, name)) != module:
            elsewhere.append(f"- {{py:obj}}`{name} <{place}.{name}>`: {escaped(summary_of(module, name))}")
        else:
            entries.append(entry(module, name))
    also = ["## On other pages\n", "\n".join(elsewhere) + "\n"] if elsewhere else []
    return "\n".join([*intro, *also, *(["## Names\n"] if entries else []), *entries])


def summary(value: Any) -> str:
    """Return the first line of what is said about a thing."""
    return (inspect.getdoc(value) or "").partition("\n")[0]


def summary_of(module: str, name: str) -> str:
    """Return the first line of what is said about a name."""
    value = getattr(importlib.import_module(module), name)
    return (documentation(module, name, value) or "").partition("\n")[0]


def documentation(module: str, name: str, value: Any) -> str:
    """Return the docstring; of constants the text below them, of tables what they hold."""
    if isinstance(value, Table):
        return f"Table of {value.kind}; `make` of each gives {value.product}: {', '.join(f'`{n}`' for n in value)}."
    if isinstance(value, UnionType):
        return f"Either of {', '.join(f'`{kind.__name__}`' for kind in get_args(value))}."
    said = constant_doc(module, name)
    if said or not (inspect.isclass(value) or inspect.isroutine(value) or hasattr(value, "py_func")):
        return said
    return inspect.getdoc(getattr(value, "py_func", value)) or ""


@cache
def constant_doc(module: str, name: str) -> str:
    """Return the text below a constant's assignment, followed through imports; empty if it is none."""
    tree = _tree(module)
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        targets = (
            node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        )
        if any(isinstance(t, ast.Name) and t.id == name for t in targets):
            said = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
            return inspect.cleandoc(str(after.value.value)) if said else ""
        if isinstance(node, ast.ImportFrom) and any((a.asname or a.name) == name for a in node.names):
            original = next(a.name for a in node.names if (a.asname or a.name) == name)
            return constant_doc(str(node.module), original)
    return ""


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(Path(inspect.getfile(importlib.import_module(module))).read_text("utf-8"))


def entry(module: str, name: str) -> str:
    """Return the entry of a name as a directive of the Python domain."""
    value = getattr(importlib.import_module(module), name)
    said = markdown(documentation(module, name, value))
    if inspect.isclass(value):
        body = [said, *members(value)]
        return directive("exception" if issubclass(value, BaseException) else "class", name + signature(value), body)
    if inspect.isroutine(value) or hasattr(value, "py_func"):
        return directive("function", name + signature(getattr(value, "py_func", value)), [said])
    shown = "" if isinstance(value, Table) else repr(value) if len(repr(value)) < 80 else ""
    keys = f"\nKeys: {', '.join(f'`{key}`' for key in value)}.\n" if isinstance(value, dict) else ""
    return directive("data", name, [said, f"\nValue: `{shown}`\n" if shown and not keys else keys])


def directive(kind: str, head: str, body: list[str], depth: int = 6) -> str:
    """Return a directive; the deeper, the fewer colons."""
    fence = ":" * depth
    return f"{fence}{{py:{kind}}} {head}\n\n" + "\n".join(filter(None, body)) + f"\n{fence}\n"


def signature(value: Any) -> str:
    """Return the arguments, without long reprs and without modules' names in annotations."""
    if inspect.isclass(value) and (
        issubclass(value, (enum.Enum, BaseException)) or getattr(value, "_is_protocol", False)
    ):
        return ""
    try:
        found = inspect.signature(value)
    except (TypeError, ValueError):
        return ""
    arguments = [p.replace(annotation=p.empty, default=_short(p.default)) for p in found.parameters.values()]
    return str(found.replace(parameters=[p for p in arguments if p.name != "self"], return_annotation=found.empty))


class _Shown:
    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def _short(default: Any) -> Any:
    text = repr(default)
    short = default is inspect.Parameter.empty or (len(text) < 40 and "<" not in text and " object" not in text)
    return default if short else _Shown("...")


def members(value: type) -> Iterator[str]:
    """Yield the fields of a record, the members of an enumeration, properties and methods."""
    if issubclass(value, enum.Enum):
        yield table([[f"`{m.name}`", f"`{m.value!r}`"] for m in value], ["member", "value"])
    elif dataclasses.is_dataclass(value) and "\nAttributes\n--" not in (inspect.getdoc(value) or ""):
        yield "\n" + fields(value)
    for name, member in vars(value).items():
        if name.startswith("_") or not _documented(member):
            continue
        function = getattr(member, "func", None) or getattr(member, "fget", None) or getattr(member, "__func__", member)
        is_property = isinstance(member, property) or type(member).__name__ == "cached_property"
        if inspect.isfunction(function) and inspect.getdoc(function):
            head = name if is_property else name + signature(function)
            yield directive(
                "property" if is_property else "method", head, [markdown(inspect.getdoc(function) or "")], 4
            )


def _documented(member: Any) -> bool:
    kinds = (property, staticmethod, classmethod)
    return inspect.isfunction(member) or isinstance(member, kinds) or type(member).__name__ == "cached_property"


def fields(record: type) -> str:
    """Return the fields of a dataclass as a table: parameters with unit and range, others with the text below them."""
    below = _field_docs(record)
    rows = []
    for field in dataclasses.fields(record):
        if field.name.startswith("_"):
            continue
        default = "" if field.default is dataclasses.MISSING else f"`{_short(field.default)!r}`"
        kind = field.type if isinstance(field.type, str) else getattr(field.type, "__name__", str(field.type))
        known = next((said for said in field.metadata.values() if isinstance(said, Parameter)), None)
        meaning = known.meaning if known else below.get(field.name, "")
        rows.append(
            [
                f"`{field.name}`",
                f"`{kind}`".replace("|", "\\|"),
                known.unit if known else "",
                default,
                escaped(" ".join(filter(None, [meaning, known.range if known else ""]))),
            ]
        )
    return table(rows, ["field", "type", "unit", "default", "meaning"]) if rows else ""


def _field_docs(record: type) -> dict[str, str]:
    body = next(
        (
            n.body
            for n in ast.walk(_tree(record.__module__))
            if isinstance(n, ast.ClassDef) and n.name == record.__name__
        ),
        [],
    )
    pairs = zip(body, [*body[1:], None], strict=True) if body else ()
    return {
        node.target.id: inspect.cleandoc(after.value.value).replace("\n", " ")
        for node, after in pairs
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
        if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) and isinstance(after.value.value, str)
    }
