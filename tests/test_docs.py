"""Everything that README.md and docs/ show as Python runs and prints what the page says.

On a page, ```python blocks run in order in one namespace, in a temporary folder that sees `examples/`.
An ```output block states what the blocks since the last one print. Anything that is not to run is ```text.
"""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from holonom.app.cell.check import check_cell

ROOT = Path(__file__).resolve().parents[1]
FENCE = re.compile(r"^```(?P<kind>python|output)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


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
        with contextlib.redirect_stdout(printed):
            exec(compile("\n" * line + block, name, "exec"), namespace)


def pages() -> list[Path]:
    found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    return [page for page in found if "_build" not in page.parts and "```python" in page.read_text("utf-8")]


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(ROOT).as_posix())
def test_code_on_the_page_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
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
