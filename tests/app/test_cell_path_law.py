"""Laws of a path in cells: by name or with parameters, within the cell's limits; refused where they cannot be."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from cell_files import built
from test_every_base import cell, refused

from holonom.app.console.cli import main
from holonom.control.path_laws.mpc import LinearMpc
from holonom.control.path_laws.stanley import StanleySettings


def test_by_name_with_parameters_and_limits(tmp_path: Path) -> None:
    more = '[limits]\nspeed = "1.5m/s"\nacceleration = "1.2m/s2"\nside_speed = "0.1m/s"\ndead_band = "5mm/s"\n'
    given = 'law = { kind = "stanley", gain = 2.5, max_turn_rate = "2rad/s" }'
    settings = built(cell(tmp_path, "ackermann", given, more)).bases[0].settings
    assert settings.law is not None
    law = settings.law.settings
    assert isinstance(law, StanleySettings)
    assert (law.gain, law.max_turn_rate, law.max_speed, law.max_acceleration) == (2.5, 2.0, 1.5, 1.2)
    assert settings.shaping.side_speed == 0.1
    assert settings.shaping.dead_band == 0.005
    assert isinstance(built(cell(tmp_path, "ackermann", 'law = "mpc"')).bases[0].settings.law, LinearMpc)
    assert built(cell(tmp_path, "ackermann")).bases[0].settings.law is None
    usual = built(cell(tmp_path, "ackermann", more=more)).bases[0].settings.law
    assert usual is not None
    assert usual.settings.max_acceleration == 1.2


@pytest.mark.parametrize("law", ["kanayama", "stanley", "pure_pursuit", "mpc"])
def test_a_cell_drives_by_it(law: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if law == "mpc":
        pytest.importorskip("osqp", reason="OSQP is not installed; pip install -e '.[mpc]'")
    out = tmp_path / "out"
    file = cell(tmp_path, "ackermann", f'law = "{law}"\nposition_tolerance = "30mm"')
    assert main(["run", str(file), "-o", str(out), "--quiet"]) == 0, capsys.readouterr().err
    assert json.loads((out / "summary.json").read_text("utf-8"))["path_driven"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    "arrangement", ["ackermann", "tricycle", "bicycle", "dual_ackermann", "differential", "swerve"]
)
def test_a_path_with_cusps(arrangement: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Into a parking space beside: forwards, backwards; never 30 mm off, 20 mm RMS by `test_path_laws_driven`."""
    file, poses = cell(tmp_path, arrangement), '[["0m", "0m", "0deg"], ["0m", "0.8m", "0deg"]]'
    text = file.read_text("utf-8").replace('shape = "circle"\nsize = "3m"', f'shape = "reeds_shepp"\nposes = {poses}')
    text = text.replace('speed = "0.8m/s"', 'radius = "0.8m"\nposition_tolerance = "30mm"\nspeed = "0.8m/s"')
    file.write_text(text, "utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--quiet"]) == 0, capsys.readouterr().err


def test_laws_that_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(cell(tmp_path, "omni", 'law = "stanley"'), capsys)
    assert "path.law" in said
    assert "it moves sideways at once" in said
    assert "no law of a path 'stanly'" in refused(cell(tmp_path, "ackermann", 'law = "stanly"'), capsys)
    said = refused(cell(tmp_path, "ackermann", 'law = { kind = "ltv", max_speed = "0.5m/s" }'), capsys)
    assert "max_speed of ltv is 0.5; the path asks for 0.8: drive it slower, or state max_speed" in said
    assert "gain" in refused(cell(tmp_path, "ackermann", 'law = { kind = "stanley", gain = -1.0 }'), capsys)


def test_mpc_without_its_library(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Found before anything runs."""
    monkeypatch.setitem(sys.modules, "osqp", None)
    assert "OSQP" in refused(cell(tmp_path, "ackermann", 'law = "mpc"'), capsys)
