"""Everything that README.md and docs/ show as Python runs and prints what the page says.

On a page, ```python blocks run in order in one namespace, in a temporary folder that sees `examples/`.
An ```output block states what the blocks since the last one print. A ```toml, ```arps or ```py block whose first line
is a comment with a file's name is written there; each line `$ holonom ...` of a ```console block is run, and has to end
with the status 0. Anything that is not to run is ```text.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from holonom.app.cell.check import check_cell
from holonom.app.console.cli import main

ROOT = Path(__file__).resolve().parents[1]
FENCE = re.compile(r"^```(?P<kind>python|output|console|toml|arps|py)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"[#;] ([\w/]+\.\w+)\n")
RUN = ("```python", "```console")
_MADE = ("_build", "reference")


def blocks(text: str) -> Iterator[tuple[str, int, str]]:
    """Kind, first line number and text of each block that is run or compared."""
    for match in FENCE.finditer(text):
        yield match["kind"], text.count("\n", 0, match.start("text")), match["text"]


def run_page(text: str, name: str) -> None:
    namespace: dict[str, object] = {"__name__": "__page__"}
    printed = io.StringIO()
    for kind, line, block in blocks(text):
        if kind == "output":
            assert printed.getvalue().rstrip() == block.rstrip(), f"{name}:{line}: the page says otherwise"
            printed.seek(0)
            printed.truncate()
            continue
        if kind not in ("python", "console"):
            if named := FILE.match(block):
                Path(named[1]).parent.mkdir(parents=True, exist_ok=True)
                Path(named[1]).write_text(block, "utf-8")
            continue
        if kind == "console":
            run_commands(block, f"{name}:{line}")
            continue
        with contextlib.redirect_stdout(printed):
            exec(compile("\n" * line + block, name, "exec"), namespace)


def run_commands(block: str, place: str) -> None:
    for words in re.findall(r"^\$ holonom (.*)$", block, re.MULTILINE):
        assert main(shlex.split(words, comments=True)) == 0, f"{place}: holonom {words}"


def pages() -> list[Path]:
    docs = ROOT / "docs"
    found = [page for page in sorted(docs.rglob("*.md")) if page.relative_to(docs).parts[0] not in _MADE]
    return [page for page in [ROOT / "README.md", *found] if any(fence in page.read_text("utf-8") for fence in RUN)]


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_code_on_the_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", list(sys.path))
    run_page(page.read_text("utf-8"), page.relative_to(ROOT).as_posix())


def test_cells_on_the_readme_are_sound(tmp_path: Path) -> None:
    cells = re.findall(r"^```toml\n(.*?)^```$", (ROOT / "README.md").read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert cells
    for text in cells:
        (tmp_path / "cell.toml").write_text(text, "utf-8")
        assert not check_cell(tmp_path / "cell.toml").data["warnings"]


def test_a_page_that_lies_is_found() -> None:
    page = "```python\nprint(1 + 1)\n```\n\n```output\n{}\n```\n"
    run_page(page.format(2), "page.md")
    with pytest.raises(AssertionError, match=r"page.md:5"):
        run_page(page.format(3), "page.md")


def test_a_command_that_fails_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    page = "```toml\n# sub/cell.toml\n[cell]\n```\n\n```console\n$ holonom methods profiles  # all\n$ ls\n```\n"
    run_page(page, "page.md")
    assert (tmp_path / "sub" / "cell.toml").exists()
    with pytest.raises(AssertionError, match=r"page.md:6: holonom check sub/cell.toml"):
        run_page(page.replace("methods profiles", "check sub/cell.toml"), "page.md")


def test_the_sizes_of_files_are_those_that_are_read(root: Path) -> None:
    """`docs/files.md` has a row for each kind."""
    from holonom.files import LIMITS, MIB

    text = (root / "docs" / "files.md").read_text("utf-8")
    for name, kind in LIMITS.items():
        assert f"| `{name}` | {kind.most // MIB} MiB |" in text
