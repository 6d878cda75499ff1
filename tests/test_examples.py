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


@pytest.mark.slow
def test_the_swerve_drive_keeps_its_path_with_a_wheel_that_is_stuck(example_run: Callable[[str], Path]) -> None:
    summary = json.loads((example_run("05_swerve") / "summary.json").read_text("utf-8"))
    (fault,) = summary["dead_motors"]
    assert (fault["kind"], fault["time"]) == ("stuck", 9.0)
    assert 0.0 < fault["detected"] - 9.0 < 1.0
    assert summary["path_driven"] == pytest.approx(1.0)
    before, after = (
        next(error for error in summary["path_errors"] if error["phase"] == phase)
        for phase in ("before the first fault", "front left: steering stuck")
    )
    assert before["rms_m"] < 0.01
    assert after["rms_m"] < 0.05
