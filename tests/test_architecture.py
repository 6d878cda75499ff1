"""What architecture and house style promise, kept true: layers, public names, light imports, file sizes."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import holonom
from holonom import errors

ROOT = Path(__file__).resolve().parents[1]
SOURCES = sorted((ROOT / "src").rglob("*.py"))
PACKAGES = sorted(module.name for module in pkgutil.walk_packages(holonom.__path__, "holonom.") if module.ispkg)
ERRORS = [getattr(errors, name) for name in errors.__all__]
HEAVY = {"cv2", "lark", "llvmlite", "mcap", "numba", "pydantic", "rich", "scipy"}


def python(code: str) -> str:
    """What a fresh interpreter prints; the warnings filter of this one does not reach it."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_layers_hold() -> None:
    pytest.importorskip("importlinter", reason="import-linter is not installed; pip install -e '.[check]'")
    command = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports())"
    done = subprocess.run([sys.executable, "-c", command], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_import_is_light() -> None:
    loaded = set(python("import sys, holonom; print(*sys.modules)").split())
    assert "holonom" in loaded
    assert not HEAVY & loaded


def test_help_is_light() -> None:
    code = """
import contextlib, io, sys
from holonom.app.console.cli import main
with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
    main(["--help"])
print(*sys.modules)
"""
    loaded = set(python(code).split())
    assert "holonom.app.console.cli" in loaded
    assert not HEAVY & loaded


def test_root_names_are_few_and_there() -> None:
    assert len(holonom.__all__) <= 24
    for name in holonom.__all__:
        assert getattr(holonom, name) is not None


@pytest.mark.parametrize("package", PACKAGES)
def test_public_names(package: str) -> None:
    module = importlib.import_module(package)
    assert inspect.getdoc(module), f"{package} has no table of contents"
    names = module.__all__
    assert len(names) == len(set(names))
    for name in names:
        public = getattr(module, name)
        if callable(public) and getattr(public, "__module__", "").startswith("holonom"):
            assert inspect.getdoc(public), f"{package}.{name} has no docstring"


def test_error_tree_is_drawn_as_it_is() -> None:
    assert errors.__doc__ is not None
    drawn: dict[str, str] = {}
    path: list[str] = []
    for indent, name in re.findall(r"^([│├└─ ]*)(\w+)(?: {2,}|$)", errors.__doc__.split("\n\n")[1], re.MULTILINE):
        del path[len(indent) // 4 :]
        drawn[name] = path[-1] if path else "Exception"
        path.append(name)
    raised = [error for error in ERRORS if not issubclass(error, Warning)]
    assert drawn == {error.__name__: error.__bases__[0].__name__ for error in raised}


@pytest.mark.parametrize("error", [error for error in ERRORS if not error.__subclasses__()], ids=lambda e: e.__name__)
def test_every_error_has_a_test(error: type[Exception]) -> None:
    others = [path for path in (ROOT / "tests").rglob("test_*.py") if path != Path(__file__)]
    assert any(error.__name__ in path.read_text("utf-8") for path in others)


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.relative_to(ROOT / "src").as_posix())
def test_file_is_short_and_strict(source: Path) -> None:
    text = source.read_text("utf-8")
    assert source.name != "utils.py", "say what is in it"
    assert text.count("\n") <= 400, "split it by meaning"
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.keyword) and node.arg == "fastmath" and isinstance(node.value, ast.Constant):
            assert node.value.value is not True, "fastmath=True deletes NaN tests; name the flags"


def test_constraints_are_pins_and_nothing_else() -> None:
    lines = [line for line in (ROOT / "constraints.txt").read_text("utf-8").splitlines() if line[:1] != "#"]
    assert lines
    for line in lines:
        assert re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", line), line


@pytest.mark.parametrize("path", [p for p in SOURCES if {"machine", "sim", "closed_loop"} & set(p.parts)], ids=str)
def test_no_function_of_controller_or_plant_is_long(path: Path) -> None:
    """60 lines at most, docstring and signature included."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno is not None
            assert node.end_lineno - node.lineno < 60, f"{path}:{node.lineno}: {node.name}"


def test_controller_and_plant_do_not_know_each_other() -> None:
    """The layers say so, too; here in words: neither package's text names the other."""
    for package, other in (("machine", "sim"), ("sim", "machine")):
        for path in (ROOT / "src" / "holonom" / package).rglob("*.py"):
            assert f"holonom.{other}" not in path.read_text(encoding="utf-8"), path
