"""Bases among obstacles: what they cover of the floor decides, not a circle around it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import holonom as hm
from holonom.app.console.cli import main
from holonom.app.recording import read_recording
from holonom.geometry import margin

CAR = (Path(__file__).resolve().parents[2] / "examples" / "04_car" / "cell.toml").read_text("utf-8")


def test_a_footprint_covers_every_wheel_however_it_is_steered() -> None:
    rng = np.random.default_rng(0)
    for base in (hm.mobile.ackermann(0.5, 0.3, 0.06), hm.mobile.bicycle(1.0, 0.3), hm.mobile.sphere(0.1)):
        corners = hm.mobile.footprint(base)
        for wheel in base.wheels:
            turn = rng.uniform(-np.pi, np.pi, 200)
            rim = np.stack([wheel.x + wheel.radius * np.cos(turn), wheel.y + wheel.radius * np.sin(turn)], axis=1)
            assert (margin(corners, rim) > -1e-9).all()
        area = 0.5 * np.sum(corners[:, 0] * np.roll(corners[:, 1], -1) - corners[:, 1] * np.roll(corners[:, 0], -1))
        assert area > 0.0
    long = hm.mobile.footprint(hm.mobile.ackermann(0.5, 0.3, 0.06))
    assert np.ptp(long, axis=0) == pytest.approx([0.62, 0.42], rel=0.01)


def test_a_car_parks_between_two_cars(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nobody is hit; each way along the path with a cusp; the car stands between them, along the kerb."""
    (tmp_path / "cell.toml").write_text(CAR, "utf-8")
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    tracks = read_recording(tmp_path / "out" / "recording.mcap").true_base
    speed = tracks.twist[np.abs(tracks.twist[:, 0]) > 0.02, 0]
    assert np.count_nonzero(np.diff(np.sign(speed))) >= 4, "cusps"
    assert tracks.pose[-1] == pytest.approx([0.0, -0.48, 0.0], abs=0.015)
    assert "the base hit" not in capsys.readouterr().err


def test_a_gap_that_is_too_small_is_found_before_and_in_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(CAR.replace('"1160mm"', '"1060mm"'), "utf-8")
    assert main(["check", str(file)]) == 2
    assert "the base would hit parked in front at " in capsys.readouterr().err
    assert main(["run", str(file), "-o", str(tmp_path / "out"), "--quiet"]) == 1
    assert "the base hit parked in front" in capsys.readouterr().err
    end = read_recording(tmp_path / "out" / "recording.mcap").true_base.pose[-1]
    corners = hm.mobile.footprint(hm.mobile.ackermann(0.52, 0.3, 0.065))
    c, s = np.cos(end[2]), np.sin(end[2])
    front = corners @ np.array([[c, s], [-s, c]]) + end[:2]
    assert abs(front[:, 0].max() - 0.66) < 0.03, "it stopped where it touched"


def test_what_hangs_above_a_base_is_not_in_its_way(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "cell.toml"
    bridge = '[[obstacle]]\nname = "bridge"\npose = { position = ["0m", "0m", "1m"], angle = "0deg" }\n'
    file.write_text(CAR + bridge + 'size = ["1m", "1m", "200mm"]\n', "utf-8")
    assert main(["check", str(file)]) == 0
    assert "mm from kerb at " in capsys.readouterr().out
