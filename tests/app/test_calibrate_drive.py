"""`holonom calibrate drive`: logs of ramps and steps, recordings of bases, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from holonom.app.calibrate.drive import calibrate_drive
from holonom.app.console.cli import main
from holonom.errors import CalibrationError, LogError
from holonom.mobile.drive.identification import MotorConstants


def log(path: Path, **columns: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return path


def motion(kS: float, kV: float, kA: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speeds that are given, 3 + sin, and the voltages that they need: no integration."""
    t = np.arange(0.0, 12.0, 0.005)
    angle = 3.0 * t + 1.0 - np.cos(t) + 0.3 * np.sin(3.0 * t)
    middle = t + 0.0025  # held until the next sample
    speed = 3.0 + np.sin(middle) + 0.9 * np.cos(3.0 * middle)
    return t, kS + kV * speed + kA * (np.cos(middle) - 2.7 * np.sin(3.0 * middle)), angle


def test_each_wheel_of_a_log(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (t, left, phi), (_, right, _) = motion(0.5, 0.8, 0.2), motion(0.7, 0.9, 0.1)
    path = log(tmp_path / "drive.csv", time=t, voltage_left=left, angle_left=phi, voltage_right=right, angle_right=phi)
    motor = MotorConstants(2.0, 0.02, gear=20.0)
    data = calibrate_drive(path, motor=motor, output=tmp_path / "out").data
    assert json.loads((tmp_path / "out" / "drive.json").read_text(encoding="utf-8")) == json.loads(json.dumps(data))
    for name, constants in (("left", (0.5, 0.8, 0.2)), ("right", (0.7, 0.9, 0.1))):
        wheel = data["wheels"][name]
        for key, unit, value in zip(("kS", "kV", "kA"), ("V", "V s/rad", "V s^2/rad"), constants, strict=True):
            assert wheel[key]["value"] == pytest.approx(value, rel=0.005)
            assert wheel[key]["unit"] == unit
            assert wheel[key]["sigma"] > 0.0
        assert wheel["inertia"]["value"] == pytest.approx(constants[2] * 0.2, rel=0.005)
        assert wheel["viscous_friction"]["unit"] == "N m s/rad"
    assert main(["calibrate", "drive", str(path), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert set(printed["wheels"]["left"]) == {"kS", "kV", "kA", "misfit_V"}


def test_one_motor_by_its_speed(tmp_path: Path) -> None:
    t, V, _ = motion(0.5, 0.8, 0.2)
    path = log(tmp_path / "m.csv", time=t, voltage=V, speed=3.0 + np.sin(t) + 0.9 * np.cos(3.0 * t), heat=t)
    answer = calibrate_drive(path)
    assert answer.data["wheels"]["motor"]["kV"]["value"] == pytest.approx(0.8, rel=0.005)
    assert answer.data["notes"] == [f"{path}:1: not read: column heat"]
    assert "kS" in answer.text


def test_refusals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t, V, phi = motion(0.5, 0.8, 0.2)
    still = log(tmp_path / "s.csv", time=t, voltage_left=V, angle_left=phi, voltage_right=V, angle_right=0.0 * t)
    with pytest.raises(CalibrationError, match=r"s.csv: right: it never turns: record a slow ramp"):
        calibrate_drive(still)
    for name, columns, match in (
        ("a.csv", {"time": t, "angle": phi}, "columns time, angle came; time, and voltage_NAME"),
        ("b.csv", {"time": t, "voltage_left": V}, "voltage_left came without angle_left or speed_left"),
        ("c.csv", {"time": np.flip(t), "voltage": V, "angle": phi}, "time must grow"),
    ):
        with pytest.raises(LogError, match=match):
            calibrate_drive(log(tmp_path / name, **columns))
    (tmp_path / "d.mcap").write_bytes(b"no recording")
    with pytest.raises(LogError, match=r"d\.mcap"):
        calibrate_drive(tmp_path / "d.mcap")
    assert main(["calibrate", "drive", str(still), "--resistance", "2.0"]) == 2
    assert "--resistance and --torque-constant are needed together" in capsys.readouterr().err
