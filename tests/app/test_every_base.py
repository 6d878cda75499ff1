"""Every arrangement of wheels is driven from a cell: its path is kept, its report is written."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from holonom.app.cell import load_cell
from holonom.app.console.cli import main
from holonom.app.recording import read_recording

WHEELS = {
    "differential": 'track = "300mm"\nwheel_radius = "50mm"\ncom = ["-50mm", "0mm"]',
    "tricycle": 'wheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"',
    "bicycle": 'wheelbase = "800mm"\nwheel_radius = "100mm"',
    "ackermann": 'wheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"\nmax_steering = "35deg"',
    "dual_ackermann": 'wheelbase = "500mm"\ntrack = "400mm"\nwheel_radius = "50mm"',
    "synchro": 'radius = "200mm"\nwheel_radius = "50mm"',
    "omni": 'radius = "200mm"\nwheel_radius = "50mm"\nn = 3',
    "mecanum": 'wheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"',
    "swerve": 'wheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"',
    "skid_steer": 'wheelbase = "200mm"\ntrack = "400mm"\nwheel_radius = "50mm"\neffective_track = "420mm"',
    "sphere": 'wheel_radius = "100mm"',
    "segway": 'track = "400mm"\nwheel_radius = "100mm"',
    "rocker6": 'wheelbase = "800mm"\ntrack = "600mm"\nwheel_radius = "60mm"',
}
STEERED = ["tricycle", "bicycle", "ackermann", "dual_ackermann", "synchro", "swerve", "rocker6"]


def cell(folder: Path, arrangement: str, path: str = "", more: str = "") -> Path:
    file = folder / "cell.toml"
    file.write_text(
        f'[cell]\nname = "{arrangement}"\nseed = 1\ntime_limit = "60s"\n'
        f'[base]\narrangement = "{arrangement}"\n{WHEELS[arrangement]}\n'
        f'mass = "8kg"\n[path]\nshape = "circle"\nsize = "3m"\nspeed = "0.8m/s"\nacceleration = "1m/s2"\n'
        f"{path}\n{more}",
        "utf-8",
    )
    return file


@pytest.mark.parametrize("arrangement", WHEELS)
def test_it_keeps_its_path(arrangement: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["run", str(cell(tmp_path, arrangement)), "-o", str(out), "--quiet"]) == 0, capsys.readouterr().err
    assert "path driven" in capsys.readouterr().out
    numbers = json.loads((out / "summary.json").read_text("utf-8"))
    assert numbers["path_driven"] == pytest.approx(1.0)
    assert (out / "report.html").stat().st_size > 1000
    tracks = read_recording(out / "recording.mcap").tracks
    loads = tracks["/truth/wheel_load"].fields["load"][10:]
    swings = arrangement == "segway"  # the body's own weight goes up and down
    assert np.allclose(loads.sum(axis=1), 8.0 * 9.81, rtol=0.1 if swings else 1e-3)
    assert ("/measured/steering" in tracks) == (arrangement in STEERED)
    if arrangement in STEERED:
        angle, asked = tracks["/measured/steering"].fields["angle"], tracks["/commanded/steering"].fields["asked"]
        assert np.median(np.abs(angle - asked)) < np.radians(2.0)
        assert np.median(np.abs(tracks["/estimated/wheel_residual"].fields["residual"])) < 0.02
        assert "Steering angle" in (out / "report.html").read_text("utf-8")


def refused(file: Path, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["check", str(file)]) == 2
    return capsys.readouterr().err


def test_a_heading_that_the_base_cannot_hold(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(cell(tmp_path, "ackermann", 'heading = "fixed"'), capsys)
    assert 'sideways, which these wheels cannot roll; heading = "tangent"' in said
    said = refused(cell(tmp_path, "synchro", 'heading = "tangent"'), capsys)
    assert "this base cannot turn" in said


def test_a_path_sharper_than_the_base_can_turn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = cell(tmp_path, "ackermann")
    file.write_text(file.read_text("utf-8").replace('"35deg"', '"10deg"'), "utf-8")
    assert "a curve of 1.5 m; the tightest that these wheels drive is 2.42 m" in refused(file, capsys)


def test_usual_steering_motors_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(cell(tmp_path, "swerve"))]) == 0
    assert (
        "no steering motors are stated; usual ones are taken: 6 rad/s, 20 N m and a lag of 20 ms"
        in capsys.readouterr().out
    )
    more = '[steering]\nmax_rate = "200deg/s"\nlag = "30ms"\n'
    assert main(["check", str(cell(tmp_path, "swerve", more=more))]) == 0
    assert "steering motors" not in capsys.readouterr().out


def test_a_steering_motor_that_is_stuck(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is found, named, and the base stops."""
    stuck = '[[faults]]\ntime = "1s"\nkind = "steering_stuck"\nwheel = "front left"\n'
    file = cell(tmp_path, "bicycle", more=stuck)
    assert "no steered wheel 'front left'" in refused(file, capsys)
    text = file.read_text("utf-8").replace("front left", "front").replace("circle", "figure_of_eight")
    file.write_text(text, "utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--quiet"]) == 1
    said = capsys.readouterr().err
    assert "stopped with stuck steering" in said
    assert "steering of front stuck; found after" in said
    events = [event.text for event in read_recording(tmp_path / "out" / "recording.mcap").events]
    assert "the steering of front is stuck" in events
    assert "the steering of front is stuck; the base stops" in events


@pytest.mark.parametrize("arrangement", STEERED)
def test_ideal_wheels_and_velocities(arrangement: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Wheels that turn as they are told; velocities that ask for wheels to be turned over: what is driven waits."""
    file = cell(tmp_path, arrangement, more='[limits]\nspeed = "1m/s"\n')
    path = file.read_text("utf-8")
    file.write_text(path.replace('mass = "8kg"', 'mass = "8kg"\ndrives = "ideal"'), "utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "ideal"), "--quiet"]) == 0, capsys.readouterr().err
    steps = '{ at = "0s", vx = "0.5m/s", w = "20deg/s" }, { at = "2s", vx = "-0.4m/s", vy = "0.2m/s" }, { at = "4s" }'
    asked = path[: path.index("[path]")] + f"velocity = [{steps}]\n"
    file.write_text(asked, "utf-8")
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--quiet"]) == 0, capsys.readouterr().err


def test_steering_motors_of_a_base_that_does_not_steer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = cell(tmp_path, "differential", more='[steering]\nlag = "30ms"\n')
    assert "no wheel of this base is steered" in refused(file, capsys)


def test_moments_of_inertia(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = cell(tmp_path, "differential")
    plain = file.read_text("utf-8")
    stated = 'mass = "8kg"\ninertia = ["0.1kgm2", "0.2kgm2", "0.25kgm2"]'
    file.write_text(plain.replace('mass = "8kg"', stated), "utf-8")
    base = load_cell(file).robot[0].source.base
    assert base.alpha * base.mass * base.radius**2 == pytest.approx(0.25)
    file.write_text(plain.replace('mass = "8kg"', stated.replace("0.2kgm2", "0.1kgm2")), "utf-8")
    assert "which no body has" in refused(file, capsys)
