"""Every example passes its off-line check and runs to its end, as a user runs it."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
CELLS = sorted(path.parent.name for path in EXAMPLES.glob("*/cell.toml"))


def test_there_are_examples() -> None:
    assert CELLS[:3] == ["01_sort_coins", "02_straight_lines", "03_soccer_robot"]


@pytest.mark.parametrize("name", CELLS)
def test_check_finds_nothing(name: str) -> None:
    command = [sys.executable, "-m", "holonom", "check", EXAMPLES / name / "cell.toml"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", CELLS)
def test_run_leaves_its_records(name: str, example_run: Callable[[str], Path]) -> None:
    folder = example_run(name)
    assert list(folder.rglob("*.mcap"))
    assert json.loads((folder / "summary.json").read_text("utf-8"))
    report = (folder / "report.html").read_text("utf-8")
    assert report.lstrip().lower().startswith("<!doctype html>")
