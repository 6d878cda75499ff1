"""`holonom tune AXIS.toml`: answers, the report, and what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holonom.app.console.cli import main
from holonom.control import SERVOS

AXIS = """
[motor]
preset = "maxon_re40_48v"
[supply]
voltage = 48
current_limit = "10 A"
[load]
inertia = 3e-5
coulomb = 0.002
[encoder]
counts = 2000
"""


def toml(folder: Path, text: str) -> str:
    path = folder / "axis.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    assert main([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_gains_what_they_do_and_a_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = toml(tmp_path, AXIS)
    data = answer(capsys, "tune", file, "-o", str(tmp_path / "out"))
    assert set(data) == {"motor", "loops", "verified", "warnings"}
    assert set(data["loops"]) == {"current", "speed", "position"}
    keys = {"form", "Kc", "Ti", "Td", "crossover", "phase_margin_deg", "gain_margin", "delay"}
    assert all(set(loop) == keys for loop in data["loops"].values())
    v = data["verified"]
    assert set(v) >= {
        "overshoot_percent", "settling_time", "following_error", "peak_current", "peak_voltage", "winding_temperature",
        "position_ripple",
    }  # fmt: skip
    assert v["overshoot_percent"] <= 1.0
    assert v["settling_time"] <= 0.15
    assert v["end_error"] <= 2 * 2.0 * math.pi / 2000
    assert 45.0 <= data["loops"]["speed"]["phase_margin_deg"] <= 70.0
    assert data["loops"]["current"]["Ti"] == pytest.approx(0.33e-3 / 1.13, rel=1e-6)
    assert data["motor"]["name"] == "maxon RE 40 148877 48 V"
    assert json.loads((tmp_path / "out" / "tuning.json").read_text("utf-8")) == data
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert page.count("<svg") == 5
    for heading in ("The axis", "Gains", "A step", "A move there and back", "Torque and speed", "Spread"):
        assert f"<h2>{heading}</h2>" in page
    step = np.loadtxt(tmp_path / "out" / "step.csv", delimiter=",", skiprows=1)
    assert step[-1, 2] == pytest.approx(1.0, abs=0.01)
    assert main(["tune", file]) == 0
    assert "settles in 97 ms" in capsys.readouterr().out


def test_a_sheet_instead_of_a_preset_and_wishes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sheet = '[motor]\nU = 48\nR = 1.13\nL = "0.33 mH"\nkM = 0.0603\nJ = 1.37e-5\nI0 = 0.0686\nn0 = 7590\n'
    rest = AXIS.split("\n", 3)[3].replace("2000", "200")
    file = toml(tmp_path, sheet + rest + "[wanted]\nstep = 0.5\nsettling_time = 0.001\n[gear]\nratio = 10\n")
    data = answer(capsys, "tune", file)
    assert [warning["name"] for warning in data["warnings"]] == ["encoder_supervision", "wanted_settling_time"]
    assert all({"name", "text", "value", "wanted"} == set(warning) for warning in data["warnings"])
    assert data["verified"]["winding_temperature"] is None


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[encoder]\ncounts = 2000\n", "", "a table [encoder] is needed to tune an axis"),
        ("inertia = 3e-5", "inertia = -1.0", "inertia"),
        ("inertia = 3e-5", "inertia = 0", "load.inertia: 0 came; it must be finite and greater than 0 kgm2"),
        ("counts = 2000", "counts = 2000\n[wanted]\nspeed = 1000.0", "48 V give less than 796.02 rad/s"),
        ("counts = 2000", "counts = 2000\n[wanted]\nsped = 10.0", "did you mean 'speed'"),
        ("counts = 2000", "counts = 2000\n[wanted]\nspeed = -3.0", "wanted.speed: -3.0 came"),
        ("counts = 2000", "counts = 2000\n[sample]\ncurrent = 1e-3", "no loop slower than the one around it"),
        ("maxon_re40_48v", "maxon_re41", "maxon_re40_48v"),
    ],
)
def test_what_is_wrong_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    file = toml(tmp_path, AXIS.replace(old, new))
    assert main(["tune", file, "-o", str(tmp_path / "out")]) == 2
    text = capsys.readouterr().err
    assert said in text
    assert "axis.toml" in text
    assert not (tmp_path / "out" / "tuning.json").exists()


def test_a_rule_is_for_a_process(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tune", toml(tmp_path, AXIS), "--rule", "simc"]) == 2
    assert "rules are for a [process]" in capsys.readouterr().err


def test_a_sheet_that_contradicts_itself_is_warned_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """An inertia off by 10, n0 below nN: gains come, and what they stand on is said."""
    sheet = "U = 18\nR = 3.99\nL = 0.556e-3\nkM = 0.0352\nJ = 45.3e-6\ntau_m = 14.6e-3\nn0 = 3000\nnN = 4000\n"
    file = toml(tmp_path, AXIS.replace('preset = "maxon_re40_48v"\n', sheet).replace("voltage = 48", "voltage = 18"))
    named = [w["name"] for w in answer(capsys, "tune", file)["warnings"]]
    assert {"inertia against tau_m (factor 10)", "n0 below nN"} <= set(named)


def test_what_does_not_come_to_rest_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A load that swings far below the speed loop; an encoder with 16 counts."""
    soft = AXIS.replace("inertia = 3e-5", "inertia = 0.05") + "[gear]\nratio = 50\nstiffness = 5.0\n"
    data = answer(capsys, "tune", toml(tmp_path, soft))
    said = {w["name"]: w for w in data["warnings"]}
    assert {"resonance", "not_settled", "position_ripple"} <= set(said)
    assert said["resonance"]["wanted"] == pytest.approx(0.5 * math.sqrt(5.0 / 0.05))
    assert data["verified"]["settling_time"] is None
    file = toml(tmp_path, AXIS.replace("2000", "16"))
    data = answer(capsys, "tune", file, "-o", str(tmp_path / "out"))
    assert "not_settled" in [w["name"] for w in data["warnings"]]
    assert main(["tune", file]) == 0
    assert "does not settle" in capsys.readouterr().out


ELASTIC = AXIS.replace("[encoder]", "[gear]\nratio = 10\nstiffness = 200\ngap = 1e-3\n[encoder]").replace(
    "3e-5", "3e-3"
)


@pytest.mark.parametrize("servo", [name for name in SERVOS if name != "load_side"])
def test_a_servo_that_is_wanted(tmp_path: Path, capsys: pytest.CaptureFixture[str], servo: str) -> None:
    """Every one that an axis without an encoder on its load may have; the report of those with other loops."""
    file = toml(tmp_path, f'{ELASTIC}[wanted]\nservo = "{servo}"\n')
    loops = {"one_loop": {"angle"}, "two_loops": {"current", "angle"}}
    report = ["-o", str(tmp_path / "out")] if servo in loops else []
    data = answer(capsys, "tune", file, *report)
    assert set(data["loops"]) == loops.get(servo, {"current", "speed", "position"})
    if report:
        page = (tmp_path / "out" / "report.html").read_text("utf-8")
        assert f"<td>servo</td><td class=n>{SERVOS.make(servo)}</td>" in page.replace("&#x27;", "'")
        assert "<td>stiffness</td><td class=n>200 N m/rad</td>" in page
    assert main(["tune", file]) == 0
    assert f"Kc {data['loops'].get('angle', data['loops'].get('position'))['Kc']:.5g} " in capsys.readouterr().out


def test_a_notch_holds_what_a_stiff_design_shakes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = """
[motor]
preset = "maxon_re25_24v"
[load]
inertia = 5.92e-3
coulomb = 0.001
viscous = 1e-4
[encoder]
counts = 20000
[gear]
ratio = 45
efficiency = 0.7
stiffness = 1000
"""
    shaken, held = (
        answer(capsys, "tune", toml(tmp_path, f"{text}[wanted]\nservo = {servo}\n"))
        for servo in ('"three_loops"', '{ kind = "notch" }')
    )
    assert "resonance" in {w["name"] for w in shaken["warnings"]}
    assert shaken["verified"]["settling_time"] is None
    assert "resonance" not in {w["name"] for w in held["warnings"]}
    assert held["verified"]["settling_time"] < 0.3
    assert held["verified"]["overshoot_percent"] < 1.0


@pytest.mark.parametrize(
    ("servo", "words"),
    [
        ("3", "no servo '3'"),
        ('"notches"', "did you mean 'notch'"),
        ('{ kind = "notch", depht = 1 }', "did you mean 'depth'"),
    ],
)
def test_a_servo_that_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str], servo: str, words: str) -> None:
    file = toml(tmp_path, f"{AXIS}[wanted]\nservo = {servo}\n")
    assert main(["tune", file]) == 2
    told = capsys.readouterr().err
    assert f"{file}:13: wanted.servo: " in told
    assert words in told
