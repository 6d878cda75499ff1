"""A base that balances, from its cell: laws, velocities, holding, falls, and what is refused."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from holonom.app.console.cli import main
from holonom.app.recording import read_recording

HEAD = """[cell]
name = "balance"
seed = 7
time_limit = "60s"
[base]
arrangement = "segway"
track = "400mm"
wheel_radius = "100mm"
mass = "10kg"
height = "450mm"
inertia = ["0.3kgm2", "0.25kgm2", "0.12kgm2"]
"""

AHEAD = """[path]
shape = "waypoints"
points = [["0m", "0m"], ["3m", "0m"]]
speed = "0.7m/s"
acceleration = "0.5m/s2"
"""


def run(folder: Path, text: str, head: str = HEAD) -> tuple[int, dict[str, object]]:
    file = folder / "cell.toml"
    file.write_text(head + text, "utf-8")
    status = main(["run", str(file), "-o", str(folder / "out"), "--quiet"])
    summary = folder / "out" / "summary.json"
    return status, json.loads(summary.read_text("utf-8")) if summary.exists() else {}


@pytest.mark.parametrize("law", ['"lqr"', '"cascade"', '{ kind = "lqr", error_place = "0.2m" }'])
def test_velocities_are_driven(law: str, tmp_path: Path) -> None:
    steps = '[{ at = "1s", vx = "0.5m/s", w = "1rad/s" }, { at = "3.8s" }, { at = "7s" }]'
    status, numbers = run(tmp_path, f"balance = {law}\nvelocity = {steps}\n")
    assert status == 0, numbers
    assert any("its body balances by" in str(note) for note in numbers["notes"])  # type: ignore[attr-defined]


def test_it_holds_from_a_lean(tmp_path: Path) -> None:
    lean = 'pose = { position = ["0m", "0m", "0m"], angle = "0deg", pitch = "8deg" }\nhold = "3s"\n'
    status, numbers = run(tmp_path, lean)
    assert status == 0, numbers  # it rolls 0.1 m under its body
    assert 0.05 < numbers["path_errors"][0]["peak_m"] < 0.15  # type: ignore[index]


def test_a_fall_is_told_with_its_time_and_pitch(tmp_path: Path) -> None:
    lean = 'pose = { position = ["0m", "0m", "0m"], angle = "0deg", pitch = "35deg" }\nhold = "3s"\n'
    status, numbers = run(tmp_path, lean + '[limits]\nspeed = "0.5m/s"\nacceleration = "0.3m/s2"\n')
    assert status == 1
    assert str(numbers["failure"]).startswith("falls forwards at 0.")
    assert "its body leans 60 deg" in str(numbers["failure"])


REFUSED = {
    "too low": (HEAD.replace("450mm", "80mm"), 'hold = "1s"\n', "80 mm came; a body that balances has its centre"),
    "no such law": (HEAD, 'balance = "pid"\nhold = "1s"\n', "'pid'; there is cascade, lqr"),
    "not one that balances": (
        HEAD.replace("segway", "differential").replace("height", 'com = ["-50mm", "0mm"]\nheight'),
        'balance = "lqr"\nhold = "1s"\n',
        "the body of this base does not balance",
    ),
    "it lies": (
        HEAD,
        'pose = { position = ["0m", "0m", "0m"], angle = "0deg", pitch = "70deg" }\nhold = "1s"\n',
        "beyond 60deg it has fallen",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head, text, said = REFUSED[case]
    assert run(tmp_path, text, head)[0] == 2
    assert said in capsys.readouterr().err


def test_steps_and_a_slope_of_the_floor(tmp_path: Path) -> None:
    """A slope of 2 degrees with a step of 20 mm is rolled over; on ideal drives it is said that neither is felt."""
    floor = '[floor]\nslope = "2deg"\nuphill = "90deg"\nsteps = [{ position = ["1.5m", "0m"], height = "20mm" }]\n'
    status, numbers = run(tmp_path, AHEAD + floor)
    assert status == 0, numbers
    status, numbers = run(tmp_path, 'drives = "ideal"\n' + AHEAD + floor)
    assert status == 0, numbers
    assert any("its slope and its steps change nothing for it" in str(n) for n in numbers["notes"])  # type: ignore[attr-defined]


def test_an_edge_too_high_stops_it(tmp_path: Path) -> None:
    head = HEAD.replace("segway", "differential").replace("height", 'com = ["-50mm", "0mm"]\n#').replace("inertia", "#")
    status, numbers = run(tmp_path, AHEAD + '[floor]\nsteps = [{ position = ["1m", "0m"], height = "0.2m" }]\n', head)
    assert status == 1
    assert "path" in str(numbers["failure"])


def test_its_pitch_is_recorded_and_its_body_leans_with_it(tmp_path: Path) -> None:
    """The body's frame is base_link's, turned by the true pitch about the axle."""
    run(tmp_path, 'velocity = [{ at = "0s", vx = "0.4m/s" }, { at = "1.5s" }]\n')
    recording = read_recording(next(tmp_path.rglob("recording.mcap")))
    true, seen = (recording.tracks[f"/{kind}/pitch"] for kind in ("truth", "estimated"))
    pitch, believed = true.fields["angle"][:, 0], seen.fields["seen"][:, 0]
    assert np.abs(pitch).max() > math.radians(1.0)
    assert np.abs(pitch - believed).max() < math.radians(0.5)
    base, body = recording.frames["base_link"], recording.frames["body"]
    height = 0.1  # of the axle
    leaning = Rotation.from_quat(base.quaternion).inv() * Rotation.from_quat(body.quaternion)
    at = np.searchsorted(true.time, body.time).clip(0, len(pitch) - 1)
    assert leaning.as_rotvec() == pytest.approx(np.outer(pitch[at], [0.0, 1.0, 0.0]), abs=1e-6)
    axle = body.position + Rotation.from_quat(body.quaternion).apply([0.0, 0.0, height])
    assert axle == pytest.approx(base.position + np.array([0.0, 0.0, height]), abs=1e-6)
