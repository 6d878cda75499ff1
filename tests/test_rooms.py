"""The house: few things in a room, no circle of imports, one place for what everyone needs."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import holonom
from holonom.model import JOINT_KINDS

ROOT = Path(holonom.__file__).parent
MOST = 15
"""Entries of a folder; those of the root are the layers themselves."""


def name_of(file: Path) -> str:
    parts = file.relative_to(ROOT.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(file): file for file in ROOT.rglob("*.py")}


def imported(name: str, text: str, known: Mapping[str, object]) -> Iterator[str]:
    """Modules that a text imports: anywhere in it, in a function or for types only, too."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                if whole in known:
                    yield whole
                elif node.module in known and node.module != name:
                    yield node.module


def circle(texts: Mapping[str, str]) -> list[str]:
    """One circle of imports among modules, if there is any."""
    graph = {name: {other for other in imported(name, text, texts) if other != name} for name, text in texts.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_circle_of_imports() -> None:
    assert circle({name: file.read_text("utf-8") for name, file in MODULES.items()}) == []


def test_circles_are_seen_under_type_checking_and_in_functions() -> None:
    typed = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from p.b import x\n"
    assert set(circle({"p.a": typed, "p.b": "def f():\n    from p import a\n"})) == {"p.a", "p.b"}
    assert circle({"p.a": typed, "p.b": "import p.c\n", "p.c": ""}) == []


def test_rooms_are_small() -> None:
    rooms = [room for room in ROOT.rglob("*") if room.is_dir() and room.name != "__pycache__"]
    assert len(rooms) > 40
    for room in rooms:
        entries = [entry for entry in room.iterdir() if entry.name != "__pycache__"]
        assert len(entries) <= MOST, f"{room.relative_to(ROOT)} has {len(entries)} entries; make rooms of it"


def test_gravity_is_stated_once() -> None:
    stated = [name for name, file in MODULES.items() if re.search(r"\b9\.8\d*\b", file.read_text("utf-8"))]
    assert stated == ["holonom.model.gravity"], stated


def test_arrays_have_one_alias() -> None:
    stated = [name for name, file in MODULES.items() if "= NDArray[np.float64]\n" in file.read_text("utf-8")]
    assert stated == ["holonom.arrays"]


def test_nobody_asks_for_a_kind_of_joint_by_its_name() -> None:
    """What differs from kind to kind stands in `JOINT_KINDS` and, for the equations, in `FREEDOMS`."""
    names = "|".join(f'"{name}"' for name in JOINT_KINDS if name != "fixed")  # a kind of wheel, too
    asked = re.compile(rf"(==|!=|\bin|\bcase)\s*[(\[{{]?\s*({names})")
    assert asked.search('if joint.kind == "revolute":')
    assert asked.search('kind not in ("prismatic", "revolute")')
    assert [name for name, file in MODULES.items() if asked.search(file.read_text("utf-8"))] == []
