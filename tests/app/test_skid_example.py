"""`examples/06_skid_steer`: its README, command by command."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path

import pytest

from holonom.app.cell import load_cell
from holonom.app.console.cli import main

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "06_skid_steer"


def test_its_readme_runs_as_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The track that the run tells is that of the second cell, and its odometry errs by far less there."""
    shutil.copytree(EXAMPLE, tmp_path / "skid")
    monkeypatch.chdir(tmp_path / "skid")
    lines = (EXAMPLE / "README.md").read_text("utf-8").splitlines()
    commands = [shlex.split(line)[2:] for line in lines if line.startswith("$ holonom ")]
    assert len(commands) == 4
    for command in commands:
        assert main([*command, "--quiet"] if command[0] == "run" else command) == 0
    found, checked = (json.loads(Path(folder, "odometry.json").read_text("utf-8")) for folder in ("found", "checked"))
    (nominal, second) = (load_cell(EXAMPLE / f"{name}.toml").robot[0].source.base for name in ("cell", "calibrated"))
    tracks = [2.0 * abs(base.wheels[0].acting[1]) for base in (nominal, second)]
    assert tracks[0] == pytest.approx(1.5 * 0.4), "the usual guess"
    assert found["calibrated"]["effective_track"] == pytest.approx(tracks[1], rel=0.002)
    assert found["deviations"]["effective_track"] < 0.01 * tracks[1]
    guessed, told = (data["errors_before"]["max_distance_m"] for data in (found, checked))
    assert told < 0.06 * guessed
    report = Path("runs/guessed/report.html").read_text("utf-8")
    assert "Its wheels slip to turn, which is no fault" in report
    assert "Slips with the right name" not in report
