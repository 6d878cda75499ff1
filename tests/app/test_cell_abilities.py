"""Limits of velocities that a cell leaves out: what motors and floor allow, and said in the summary."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from holonom.app.console.cli import main

CELL = """
[cell]
name = "weak"
time_limit = "5s"

[floor]
friction = {friction}
sliding_friction = 0.05

[[robot]]
velocity = [{{ at = "0s", vx = "2m/s" }}, {{ at = "1s", vx = "-2m/s" }}, {{ at = "3s" }}]
{limits}
[robot.model]
arrangement = "differential"
track = "300mm"
wheel_radius = "50mm"
mass = "17kg"
height = "60mm"
com = ["-50mm", "0mm"]

[robot.drives]
resistance = "1.2ohm"
inductance = "0.5mH"
torque_constant = "30mNm/A"
rotor_inertia = "100gcm2"
supply = "12V"
max_current = "{current}"
gear_ratio = 12
counts_per_turn = 4096
wheel_inertia = "1000gcm2"
"""


def checked(tmp_path: Path, capsys: pytest.CaptureFixture[str], **given: object) -> str:
    path = tmp_path / "cell.toml"
    path.write_text(CELL.format(**{"friction": 0.8, "current": "20A", "limits": "", **given}), "utf-8")
    assert main(["check", str(path), "--json"]) == 0
    return json.dumps(json.loads(capsys.readouterr().out))


def test_weak_motors_and_a_slippery_floor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two motors of 2 A push 2 * 12 * 0.03 * 2 / 0.05 = 28.8 N against 17 kg and what their own rotors weigh."""
    own = 2.0 * (1e-4 + 144.0 * 1e-5) / 0.05**2
    weak = 0.85 * 28.8 / (17.0 + own)
    said = checked(tmp_path, capsys, current="2A")
    assert f"acceleration {weak:.3g} m/s2" in said
    assert "are what motors and floor allow" in said
    carried = 1.0 - 0.05 / 0.3  # the castor stands a track behind the axle
    assert f"acceleration {0.85 * 0.1 * 9.80665 * carried:.3g} m/s2" in checked(tmp_path, capsys, friction=0.1)


def test_what_is_stated_or_can_be_done_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stated = 'limits = { speed = "1m/s", acceleration = "2m/s2", turn_rate = "3rad/s", turn_acceleration = "9rad/s2" }'
    assert "motors and floor allow" not in checked(tmp_path, capsys, current="2A", limits=stated)
    assert " acceleration" not in checked(tmp_path, capsys).partition("motors and floor allow")[2].split("turn")[0]
