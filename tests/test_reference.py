"""The reference is whole, formulas render or fail, and built pages load nothing from elsewhere; Sphinx is not run."""

from __future__ import annotations

import importlib
import json
import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import holonom
from holonom.app.about.doctor import EXTRAS
from holonom.app.commands import COMMANDS
from holonom.registry import parameters_of

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"


@pytest.fixture(autouse=True)
def extensions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS / "_ext")


def load(name: str) -> ModuleType:
    pytest.importorskip("sphinx", reason="sphinx is not installed; pip install -e '.[docs]'")
    return importlib.import_module(name)


def public_names(module: ModuleType, seen: set[str]) -> Iterator[tuple[str, str, Any]]:
    """Module, name and value of all that `holonom` lists, recursively."""
    seen.add(module.__name__)
    for name in module.__all__:
        value = getattr(module, name)
        yield module.__name__, name, value
        if isinstance(value, ModuleType) and value.__name__ not in seen and hasattr(value, "__all__"):
            yield from public_names(value, seen)


def test_every_public_name_has_an_entry() -> None:
    reference = load("reference_python")
    pages = reference.pages()
    names = list(public_names(holonom, set()))
    for extra in ("plots", "spatial"):
        names += public_names(getattr(holonom, extra), set())
    assert len(names) > 400
    missing = []
    for module, name, value in names:
        entry = re.search(rf"^:+{{py:\w+}} {name}(\(.*)?\n\n(.*)", pages[module], re.MULTILINE)
        link = re.search(rf"^- {{py:\w+}}`{name} <([\w.]+)>`: ?(.*)", pages[module], re.MULTILINE)
        said = entry[2] if entry else link[2] if link else ""
        if not said.strip(" :") or said.startswith(":::"):
            missing.append(f"{module}.{name}")
        if link and not isinstance(value, ModuleType):
            home, _, called = link[1].rpartition(".")
            assert re.search(rf"^:+{{py:\w+}} {called}\b", pages[home], re.MULTILINE), link[1]
    assert not missing, f"without a word in the reference: {', '.join(missing)}"


def test_every_command_and_option_has_an_entry() -> None:
    page = load("reference_tables").commands()
    for name in COMMANDS.own:
        section = re.search(rf"^## holonom {name}\n(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)
        assert section, name
        plain = section[1].replace("\\", "")
        assert len(parameters_of(COMMANDS[name].record)) == sum(
            line.startswith("| `") and "`--json`" not in line and "`--help`" not in line
            for line in section[1].split("\n")
        )
        for field in parameters_of(COMMANDS[name].record):
            said = field.parameter.meaning.partition("`")[0]
            assert said in plain, f"holonom {name}: {field.name}"
        assert {"`--json`", "`--help`"} <= set(re.findall(r"`--[\w-]+`", section[1]))
    for option in ("--arm", "--held-out", "--show-kernel", "-o"):
        assert f"`{option}`" in page


def keys_of(schema: Any) -> Iterator[str]:
    """The keys of every table that a schema describes, wherever it does."""
    if isinstance(schema, dict):
        if schema.get("type") == "object":
            yield from schema.get("properties", ())
        for value in schema.values():
            yield from keys_of(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from keys_of(value)


def test_every_key_of_a_cell_has_an_entry() -> None:
    page = load("reference_tables").cell_keys()
    wanted = Counter(keys_of(json.loads((DOCS / "cell.schema.json").read_text("utf-8"))))
    found = Counter(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE))
    assert sum(wanted.values()) > 200
    assert wanted == found
    bare = re.findall(r"^\| `(\w+)` \|(?:[^|]*\|){3} +\|$", page, re.MULTILINE)
    assert set(bare) <= {"kind"}, f"keys without a meaning: {bare}"
    assert re.search(r"^\| `time_limit` \| quantity \| s, ms, us, min \| required \| \w+", page, re.MULTILINE)


def test_names_in_the_table_of_tasks_exist() -> None:
    links = load("links")
    text = (DOCS / "tasks.md").read_text("utf-8")
    rows = re.findall(r"^\|[^|]+\|(?:[^|]+\|)?([^|]+)\|[^|]+\|$", text, re.MULTILINE)
    codes = [code for row in rows for code in re.findall(r"`([^`]+)`", row)]
    assert len(codes) > 120
    unknown = [code for code in codes if not re.search(r"=|^make |/$|\.\.\.", code) and links.resolve(code) is None]
    assert not unknown
    assert links.resolve("arm.fk") == "holonom.mechanics.Arm.fk"
    assert links.resolve("hm.load_arm(name)") == "holonom.mechanics.load_arm"
    assert links.resolve("holonom check FILE") == "holonom check"
    assert links.resolve("tool") is links.resolve("plan_nothing") is None


def test_the_drawing_of_the_layers_holds_every_package() -> None:
    layers = load("layers")
    named = {name.strip("() ") for row in layers.rows() for name in row}
    there = {
        path.stem
        for path in (ROOT / "src" / "holonom").iterdir()
        if path.stem != "__init__" and path.suffix in ("", ".py")
    }
    assert there - {"__pycache__"} <= named
    assert named <= set(layers.MEANS)


def formulas() -> Iterator[tuple[str, str]]:
    for page in sorted(DOCS.rglob("*.md")):
        if page.relative_to(DOCS).parts[0] in ("_build", "reference") or page.name == "methods.md":
            continue
        text = re.sub(r"^```.*?^```$|`[^`\n]+`", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
        for block, inline in re.findall(r"\$\$(.+?)\$\$|(?<!\\)\$([^$]+?)\$", text, re.DOTALL):
            yield page.name, block or inline


def test_every_formula_renders() -> None:
    mathml = load("formulas").mathml
    found = list(formulas())
    assert len(found) > 400
    for _, latex in found:
        assert mathml(latex).startswith("<math")


@pytest.mark.parametrize(
    "wrong", [r"\foo x", r"\frac{a}", r"{a", r"a}", r"\begin{bmatrix} 1 & 2", r"a & b", r"\Rot(z)", r"x^", ""]
)
def test_a_formula_that_cannot_be_rendered_is_refused(wrong: str) -> None:
    found = load("formulas")
    with pytest.raises(found.FormulaError):
        found.mathml(wrong)


def test_what_a_page_would_load_from_elsewhere_is_found(tmp_path: Path) -> None:
    offline = load("offline")
    far = "//cdn.example.org/x"
    for text in (
        f'<script async src="https:{far}.js"></script>',
        f"<link href='https:{far}.css' rel='stylesheet'>",
        f'<link rel="preconnect" href="{far}">',
        f"@import url({far}.css);",
        f"body {{ background: url('https:{far}.png') }}",
        f'<img alt="" src="http:{far}.png">',
        f'fetch("https:{far}.json")',
    ):
        assert len(offline.loads(text)) == 1, text
    near = '<a href="https://example.org">there</a><script src="_static/x.js"></script><link rel="index" href="i.html">'
    assert offline.loads(near) == []
    (tmp_path / "page.html").write_text(f'<script src="https:{far}.js"></script>', "utf-8")
    assert offline.check(tmp_path) == [f"page.html loads https:{far}.js"]


def test_pins_hold_what_the_docs_need() -> None:
    extra = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]["docs"]
    pinned = {line.partition("==")[0].lower() for line in (ROOT / "constraints.txt").read_text("utf-8").splitlines()}
    assert {re.split("[>=]", need)[0].lower().replace("_", "-") for need in extra} <= pinned


def test_no_cell_of_a_matrix_is_lost() -> None:
    made = load("formulas").mathml(r"\begin{pmatrix} a & b & 1\\ & \vdots & \end{pmatrix}")
    assert (made.count("<mtr>"), made.count("<mtd>")) == (2, 6)
    assert 'rspace="0.1667em">sin' in load("formulas").mathml(r"\sin\theta")


def test_files_named_on_the_page_of_methods_exist() -> None:
    paths = re.findall(r"`(holonom/[\w/.]+)`", (DOCS / "add_a_method.md").read_text("utf-8"))
    assert len(paths) > 8
    assert [path for path in paths if not (ROOT / "src" / path).exists()] == []


def test_doctor_knows_every_extra() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    assert set(EXTRAS) == set(extras) - {"all"}
    for name, extra in EXTRAS.items():
        assert set(extra.modules.values()) <= {re.split("[>=;]", need)[0] for need in extras[name]}, name


def test_a_section_that_the_pages_cannot_show_is_named() -> None:
    docstrings = load("docstrings")
    assert "**Warns**\n\n- `Loud`: Why." in docstrings.markdown("One.\n\nWarns\n-----\nLoud\n    Why.\n")
    with pytest.raises(ValueError, match="a section 'Return'; there are Parameters"):
        docstrings.markdown("One.\n\nReturn\n------\nint\n    Two.\n")
