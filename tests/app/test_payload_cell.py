"""A payload that changes at a time, from a cell."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from holonom.app.console.cli import main
from holonom.app.recording import read_recording

HEAD = """[cell]
name = "payload"
seed = 3
time_limit = "60s"
[base]
arrangement = "mecanum"
wheelbase = "400mm"
track = "300mm"
wheel_radius = "50mm"
mass = "10kg"
[path]
shape = "circle"
size = "2m"
speed = "0.8m/s"
acceleration = "1m/s2"
"""
EVENT = '[[event]]\nat = "3s"\npayload = { mass = "15kg", com = ["50mm", "20mm"], com_height = "0.2m" }\n'


def run(folder: Path, text: str) -> int:
    file = folder / "cell.toml"
    file.write_text(text, "utf-8")
    return main(["run", str(file), "-o", str(folder / "out"), "--quiet"])


def test_it_carries_a_payload_from_its_time_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(tmp_path, HEAD + EVENT) == 0, capsys.readouterr().err
    recording = read_recording(tmp_path / "out" / "recording.mcap")
    (event,) = [event for event in recording.events if "carries" in event.text]
    assert event.text == "it carries 15 kg from here on"
    assert event.time == pytest.approx(3.0, abs=0.011)
    assert json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))["outcome"] == "done"


REFUSED = {
    "neither": ('[[event]]\nat = "3s"\n', "give it one of signal and payload"),
    "both": (EVENT + "signal = 3\n", "give it one of signal and payload"),
    "of whom": ('[[event]]\nat = "3s"\nsignal = 3\nrobot = "x"\n', "signals belong to the whole cell"),
    "no such robot": (EVENT + 'robot = "agv"\n', "no robot 'agv'"),
    "too light": (EVENT.replace('"15kg"', '"-1kg"'), "mass"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, said = REFUSED[case]
    assert run(tmp_path, HEAD + text) == 2
    assert said in capsys.readouterr().err


def test_ideal_drives_feel_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(tmp_path, HEAD.replace("[path]", 'drives = "ideal"\n[path]') + EVENT) == 2
    assert "ideal drives feel no payload" in capsys.readouterr().err


def test_a_body_that_balances_takes_none_beside_its_plane(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head = HEAD.replace("mecanum", "segway").replace('wheelbase = "400mm"\n', "").replace('"50mm"', '"100mm"')
    assert run(tmp_path, head + EVENT) == 2
    assert "whose products of inertia xy and yz must be 0" in capsys.readouterr().err
    above = EVENT.replace('"20mm"', '"0mm"').replace('"50mm"', '"0mm"').replace('"15kg"', '"3kg"')
    assert run(tmp_path, head + above) == 0, capsys.readouterr().err
