"""Copies of the first example to break, and the command line to try them with."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from holonom.app.console.cli import main

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "01_sort_coins"


class CellCopy:
    """A copy of the first example in `folder`; a run of it goes to `out`."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        shutil.copytree(EXAMPLE, folder / "cell")
        self.folder, self.out, self._capsys = folder / "cell", folder / "out", capsys

    def edit(self, name: str, old: str, new: str) -> None:
        """Replace the first match of a regular expression in one of the files."""
        path = self.folder / name
        text, count = re.subn(old, lambda _: new, path.read_text("utf-8"), count=1)
        assert count == 1, f"{name} of the example no longer says {old!r}"
        path.write_text(text, "utf-8")

    def line(self, name: str, text: str) -> str:
        """Where a file says so first: its path and line, as messages give them."""
        lines = (self.folder / name).read_text("utf-8").splitlines()
        return f"{self.folder / name}:{next(k for k, line in enumerate(lines, start=1) if text in line)}"

    def call(self, command: str, *options: str) -> tuple[int, str]:
        """Run a command on the cell file; its exit status and what it says."""
        if command == "run":
            options = ("-o", str(self.out), "--quiet", *options)
        status = main([command, str(self.folder / "cell.toml"), *options])
        shown = self._capsys.readouterr()
        return status, shown.out + shown.err
