"""The reference, made at build from what the package says of itself: docs/reference/ is written, never edited."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import reference_python
import reference_tables
from sphinx.application import Sphinx

FOLDER = Path(__file__).resolve().parents[1] / "reference"


def pages() -> dict[str, str]:
    """Return every page of the reference as Markdown, by its path below docs/reference."""
    modules = reference_python.pages()
    listing = "\n".join(["python/" + module for module in modules])
    found = {f"python/{module}.md": text for module, text in modules.items()}
    found["python.md"] = f"# Python\n\n{PYTHON}\n```{{toctree}}\n:maxdepth: 1\n\n{listing}\n```\n"
    return found | {"commands.md": reference_tables.commands(), "cell.md": reference_tables.cell_keys()}


PYTHON = """Every public name, from `__all__`, signature and docstring of each module. Shape, unit and frame of an array
stand at each argument; batches lead.
"""


def write(_: Sphinx | None = None) -> None:
    """Write the pages that have changed, and remove those that there no longer are."""
    made = pages()
    for old in FOLDER.rglob("*.md"):
        if old.relative_to(FOLDER).as_posix() not in made:
            old.unlink()
    for name, text in made.items():
        page = FOLDER / name
        page.parent.mkdir(parents=True, exist_ok=True)
        if not page.exists() or page.read_text("utf-8") != text:
            page.write_text(text, "utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the pages before Sphinx looks for its sources."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
