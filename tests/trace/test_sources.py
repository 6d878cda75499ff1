"""What compiled code is said to be made of is all that it is made of."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import py_compile
import re
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import holonom
from holonom import trace
from holonom.trace.code.bytecode import runs
from holonom.trace.code.sources import imports, sources, stamp_of_text
from holonom.trace.text.emit import emit_block, emit_made, emit_pointer
from holonom.trace.text.generated import load_module

ROOT = Path(holonom.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
OWN_LOOPS = ("trace/code/loops.py", "trace/cuda.py")
"""What wraps Numba's decorator, and what compiles for another machine."""


def name_of(file: Path) -> str:
    parts = file.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


COMPILED = [name_of(file) for file in FILES if re.search(r"^ *@loop\b|\bloop\(", file.read_text("utf-8"), re.MULTILINE)]


def test_the_decorator_is_the_only_way_to_machine_code():
    for file in FILES:
        if file.relative_to(ROOT).as_posix() not in OWN_LOOPS:
            found = re.findall(r"\bn?jit\b|\bcfunc\b|\bvectorize\b|cache=True", file.read_text("utf-8"))
            assert not found, f"{file}: {found}; compile with holonom.trace.code.loops.loop or callback"
    assert len(COMPILED) > 20


def test_reading_imports_misses_none_that_python_sees():
    for file in FILES:
        text, package = file.read_text("utf-8"), name_of(file.with_name("__init__.py"))
        assert parsed(text, package) <= imports(text, package), file


def parsed(text: str, package: str) -> set[str]:
    """The names that a text imports, by Python's own reading."""
    found = set()
    for node in running(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            start = package.rsplit(".", node.level - 1)[0] if node.level else ""
            base = ".".join(filter(None, (start, node.module)))
            found |= {base, *(f"{base}.{alias.name}" for alias in node.names)}
    return found


def running(tree: ast.AST) -> Iterator[ast.AST]:
    """Every node but those that only type checkers see."""
    yield tree
    for child in ast.iter_child_nodes(tree):
        hidden = isinstance(child, ast.If) and getattr(child.test, "id", "") == "TYPE_CHECKING"
        for inside in child.orelse if isinstance(child, ast.If) and hidden else [child]:
            yield from running(inside)


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("import a.b as c, d", {"a.b", "d"}),
        ("from . import b", {"p.q", "p.q.b"}),
        ("from ..r.s import (b as c,  # (why)\n    d,\n)", {"p.r.s", "p.r.s.b", "p.r.s.d"}),
        ("from a import \\\n    b", {"a", "a.b"}),
        ("if x: import a; from b import c", {"a", "b", "b.c"}),
        ("def f():\n    from a import b\n", {"a", "a.b"}),
        ("if TYPE_CHECKING:\n    from a import b\n\n    import c\nimport d\n", {"d"}),
    ],
)
def test_every_way_of_importing_is_read(line: str, found: set[str]):
    assert imports(line, "p.q") == parsed(line, "p.q") == found


def refers(function: Any, seen: set[Any]) -> Iterator[Any]:
    """Every function, class and module of ours that a function's text leads to, directly or not."""
    function = getattr(function, "py_func", getattr(function, "_defn", getattr(function, "_pyfunc", function)))
    if not isinstance(function, types.FunctionType) or function in seen:
        return
    seen.add(function)
    yield function
    codes = [function.__code__]
    for code in codes:
        codes += [constant for constant in code.co_consts if isinstance(constant, types.CodeType)]
    names = {name for code in codes for name in code.co_names}
    held = [cell.cell_contents for cell in function.__closure__ or ()]
    for value in [*(function.__globals__[name] for name in names & function.__globals__.keys()), *held]:
        if isinstance(value, (type, types.ModuleType)):
            yield value
        else:
            yield from refers(value, seen)


def check(functions: list[Any], known: set[str]) -> int:
    seen: set[Any] = set()
    used = {inspect.getmodule(one) for function in functions for one in refers(function, seen)}
    ours = {module.__name__ for module in used if module and module.__name__.startswith("holonom.")}
    assert ours <= known
    return len(ours)


@pytest.mark.parametrize("name", COMPILED)
def test_what_compiled_functions_lead_to_is_among_their_sources(name: str):
    """By the functions themselves, as Python has them in memory, instead of by their text."""
    module = importlib.import_module(name)
    known = {found for found, _ in sources(name, inspect.getfile(module))}
    check([value for value in vars(module).values() if getattr(value, "__module__", "") == name], known)


def test_what_generated_functions_lead_to_changes_their_stamp():
    kernel = trace.compile(lambda a: [trace.sin(a[0])], {"a": 1}, {"y": 1}, name="sources_of_generated")
    for emit in (emit_made, emit_block, emit_pointer):
        text = kernel.text(emit)
        module = load_module("sources_of_generated", text)
        known = {found for name in imports(text, "") for found, _ in known_sources(name)}
        functions = [value for value in vars(module).values() if hasattr(value, "__module__") or callable(value)]
        assert check(functions, known) > 5
        assert {"holonom.trace.code.lower", "holonom.trace.line.elementary", "holonom.trace.code.transpose"} <= known
        assert module.__dict__["__stamp__"] == stamp_of_text(text) != stamp_of_text(text + "\n")


def known_sources(name: str) -> tuple[tuple[str, str], ...]:
    file = ROOT.parent / (name.replace(".", "/") + ".py")
    return sources(name, str(file)) if file.is_file() else ()


def test_own_packages_and_what_lies_beside_a_script_are_followed(tmp_path: Path):
    texts = {"mine/__init__.py": "", "mine/a.py": "from mine import b\nimport numpy", "mine/b.py": "from .c import f"}
    texts |= {"mine/c.py": "from holonom.trace.code.remainder import back", "script.py": "import mine.b, numba"}
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    below = {"mine.b", "mine.c", "holonom.trace.code.remainder"}
    found = {name for name, _ in sources("mine.a", str(tmp_path / "mine/a.py"))}
    assert below | {"mine.a", "mine"} <= found
    assert "numpy" not in found
    assert below | {"__main__"} <= {name for name, _ in sources("__main__", str(tmp_path / "script.py"))}


def test_bytecode_that_only_time_vouches_for_is_compared_by_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    file = tmp_path / "one.py"
    file.write_text("x = 1\n")
    kept, status = py_compile.compile(str(file)), file.stat()
    assert kept
    assert runs(str(file), file.read_bytes())
    assert Path(kept).read_bytes()[4] == 0b11  # by content from now on
    py_compile.compile(str(file))
    file.write_text("x = 2\n")
    os.utime(file, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert not runs(str(file), file.read_bytes())
    assert runs(str(file), file.read_bytes())
