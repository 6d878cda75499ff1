"""Conformance of every table of methods, the page that is made from them, and names that are listed once."""

from __future__ import annotations

import ast
import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from holonom.app.about import methods
from holonom.app.about.tables import TABLES, table_of
from holonom.app.console.cli import main
from holonom.errors import InputError, UnknownName
from holonom.registry import Method, check_value, read_record

ROOT = Path(__file__).resolve().parents[1]
ALL = [(kind, name) for kind in TABLES for name in table_of(kind).own]
PATTERNS = {"commands": r"[a-z]+( [a-z]+)?", "arps_words": r"[$#]?[A-Z][A-Z0-9.]*"}
SNAKE = r"[a-z][a-z0-9]*(_[a-z0-9]+)*"
LETTERS = r"K[a-z]|T[a-z]?"  # the book's, of gains


def example(method: Method) -> Any:
    """The params record with examples where it has them, else with defaults."""
    given = {f.name: f.parameter.example for f in method.fields if f.parameter.example is not None}
    return read_record(method.record, given, "example")


def test_kinds_are_those_of_their_tables() -> None:
    assert [table_of(kind).kind for kind in TABLES] == list(TABLES)
    assert len({table_of(kind).one for kind in TABLES}) == len(TABLES)
    with pytest.raises(UnknownName, match=r"no kind of method 'sensor'; .*did you mean 'sensors'"):
        table_of("sensor")


@pytest.mark.parametrize(("kind", "name"), ALL)
def test_a_method_says_what_it_is(kind: str, name: str) -> None:
    method = table_of(kind)[name]
    assert re.fullmatch(PATTERNS.get(kind, SNAKE), name)
    for line in (method.help, method.source, *(field.parameter.meaning for field in method.fields)):
        assert line == line.strip() != ""
        assert "\n" not in line
    assert dataclasses.is_dataclass(method.record)
    for field in method.fields:
        assert re.fullmatch(f"{SNAKE}|{LETTERS}", field.name)
        if not field.required and field.default is not None:
            check_value(field.name, field.default, field)


@pytest.mark.parametrize(("kind", "name"), [pair for pair in ALL if pair[0] != "commands"])
def test_make_runs(kind: str, name: str) -> None:
    table = table_of(kind)
    made = table[name].build(example(table[name]))
    assert made is not None
    if all(not f.required and f.parameter.example is None for f in table[name].fields):
        assert type(table.make(name)) is type(made)


@pytest.mark.parametrize(("kind", "name"), [pair for pair in ALL if table_of(pair[0])[pair[1]].fields])
def test_a_wrong_parameter_is_refused(kind: str, name: str) -> None:
    table = table_of(kind)
    with pytest.raises(UnknownName, match=f"no parameter of {table.one} '{name}' 'no_such'"):
        table.params(name, {"no_such": 1})
    for field in table[name].fields:
        with pytest.raises(InputError, match=field.name):
            table.params(name, {field.name: object()})
        if float in (field.type, *getattr(field.type, "__args__", ())):
            bad = (float("nan"),) * max(len(getattr(field.type, "__args__", ())), 1)
            for value in (float("nan"), bad):
                with pytest.raises(InputError, match=field.name):
                    table.params(name, {field.name: value})


def test_every_table_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["methods", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["problems"] == []
    assert {row["kind"]: row["names"] for row in data["kinds"]} == {kind: list(table_of(kind).own) for kind in TABLES}
    for kind in TABLES:
        assert main(["methods", kind, "--json"]) == 0
        rows = json.loads(capsys.readouterr().out)["methods"]
        assert [row["name"] for row in rows] == list(table_of(kind).own)
        assert main(["methods", kind]) == 0
        text = capsys.readouterr().out
        for row in rows:
            assert f"{row['name']}: {row['help']}" in text


def test_parameters_are_told_with_unit_range_and_default(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["methods", "base_controllers", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["methods"]}
    told = {p["name"]: p for p in rows["path_keeping"]["parameters"]}
    assert told["integral_time"] == {
        "name": "integral_time",
        "type": "number",
        "unit": "s",
        "range": "greater than 0 and may be infinite",
        "bounds": {"above": 0.0},
        "choices": [],
        "required": False,
        "default": 1.0,
        "meaning": "of the integral, infinite for none",
    }
    assert main(["methods", "slip_detectors"]) == 0
    text = capsys.readouterr().out
    assert "    max_acceleration = inf m/s2 [greater than 0 and may be infinite]: of the base; infinite" in text


def test_the_page_is_current() -> None:
    """`holonom methods --markdown > docs/methods.md` brings it up to date."""
    assert (ROOT / "docs" / "methods.md").read_text("utf-8") == methods.page().text + "\n"


def listed_names(tree: ast.AST) -> Iterator[tuple[int, frozenset[str]]]:
    """Every list, tuple, set, dict's keys, and Literal of at least two names in a module, with its line."""
    assigned = [node for node in ast.walk(tree) if isinstance(node, ast.Assign)]
    exported = {id(node.value) for node in assigned if ast.unparse(node.targets[0]) == "__all__"}
    for node in ast.walk(tree):
        if id(node) in exported:  # names of functions, which a module cannot but list
            continue
        entries: list[ast.expr | None] = []
        if isinstance(node, (ast.Tuple, ast.List, ast.Set)):
            entries = list(node.elts)
        elif isinstance(node, ast.Dict):
            entries = list(node.keys)
        names = [e.value for e in entries if isinstance(e, ast.Constant) and isinstance(e.value, str)]
        if len(names) == len(entries) >= 2:
            yield node.lineno, frozenset(names)


def tables_of_names() -> dict[str, frozenset[str]]:
    return {kind: frozenset(table_of(kind).own) for kind in TABLES if len(table_of(kind).own) > 1}


def listed_twice(sources: dict[str, str]) -> list[str]:
    """Lists of all names of a table, or of three and more of them, beside the one that the table is made of."""
    found: dict[str, list[str]] = {}
    for path, text in sources.items():
        for line, names in listed_names(ast.parse(text)):
            for kind, known in tables_of_names().items():
                if names == known or (len(names) > 2 and names < known):
                    found.setdefault(kind, []).append(f"{path}:{line}")
    return [f"{kind}: {', '.join(places)}" for kind, places in found.items() if len(places) > 1]


def test_no_list_of_names_is_written_twice() -> None:
    sources = {path.relative_to(ROOT).as_posix(): path.read_text("utf-8") for path in (ROOT / "src").rglob("*.py")}
    assert listed_twice(sources) == []


def test_a_second_list_is_found() -> None:
    first, second = (
        '{"midpoint": 1, "exact": 2, "turn_then_drive": 3}',
        'Literal["exact", "midpoint", "turn_then_drive"]',
    )
    assert listed_twice({"a.py": first, "b.py": f"x: {second}"}) == ["odometry_rules: a.py:1, b.py:1"]
    assert listed_twice({"a.py": 'Z = ["cascade", "computed_torque"]', "b.py": '("steel", "wood", "cascade")'}) == []


CONTROLLER = """
from dataclasses import dataclass
from holonom.registry import Method, parameter

@dataclass(frozen=True)
class Spring:
    stiffness: float = parameter(20.0, meaning="torque per error", unit="N m/rad", above=0.0)

METHOD = Method("a spring to the reference", lambda spring: spring, "Hooke, 1678", Spring)
"""
SENSOR = """
from dataclasses import dataclass
from holonom.registry import Method, parameter

@dataclass(frozen=True)
class Thermometer:
    noise: float = parameter(0.1, meaning="standard deviation of a sample", unit="K", least=0.0)

METHOD = Method("temperature of a motor", lambda sheet: sheet, "Fahrenheit, 1724", Thermometer)
"""
ADDED = [("controllers", "spring", CONTROLLER, "stiffness"), ("sensors", "thermometer", SENSOR, "noise")]


@pytest.mark.parametrize(("kind", "name", "source", "field"), ADDED, ids=[kind for kind, *_ in ADDED])
def test_one_file_adds_a_method(
    kind: str,
    name: str,
    source: str,
    field: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / f"thrown_away_{name}.py").write_text(source)
    about = tmp_path / f"thrown_away_{name}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: thrown_away_{name}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[holonom.{kind}]\n{name} = thrown_away_{name}:METHOD\n")
    assert name not in table_of(kind)
    monkeypatch.syspath_prepend(tmp_path)
    assert main(["methods", kind, "--json"]) == 0
    row = json.loads(capsys.readouterr().out)["methods"][-1]
    assert (row["name"], row["parameters"][0]["name"]) == (name, field)
    assert main(["methods", kind]) == 0
    assert f"    {field} = " in capsys.readouterr().out
    assert getattr(table_of(kind).make(name, {field: 3}), field) == 3.0
    with pytest.raises(InputError, match=f"'{name}': {field} is -1.0"):
        table_of(kind).make(name, {field: -1})
    page = methods.page().text
    assert name not in page  # which is of Holonom's own


def test_a_controller_that_is_added_is_a_choice_of_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from holonom.app.cell.model.robot import Robot

    (tmp_path / "thrown_away.py").write_text(CONTROLLER)
    about = tmp_path / "thrown_away-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: thrown_away\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[holonom.controllers]\nspring = thrown_away:METHOD\n")
    table = {"model": "pendulum", "home": ["0deg"], "controllers": ["spring"]}
    with pytest.raises(ValueError, match="no controller 'spring'"):
        Robot.model_validate(table)
    monkeypatch.syspath_prepend(tmp_path)
    assert [law.name for law in Robot.model_validate(table).controllers] == ["spring"]


def test_a_package_that_is_wrong_is_a_note(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    about = tmp_path / "broken-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[holonom.sensors]\nnose = broken:METHOD\n[holonom.commands]\nrun = b:C\n")
    monkeypatch.syspath_prepend(tmp_path)
    note = "sensor 'nose' = broken:METHOD of broken cannot be loaded: ModuleNotFoundError"
    for words in (["methods", "sensors"], ["methods"]):
        assert main(words) == 0
        assert note in capsys.readouterr().out
    assert main(["--help"]) == 0
    assert "more than one command is called 'run': Holonom's own, 'run' = b:C of broken" in capsys.readouterr().out
    assert main(["run", "cell.toml"]) == 2
    assert "more than one command is called 'run'" in capsys.readouterr().err
