"""One run path: it records as it goes, stops when told, keeps its folder, and takes methods from other packages."""

from __future__ import annotations

import itertools
import json
import os
import random
import resource
import signal
import struct
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader

from holonom import load_arm
from holonom.app.console.cli import main
from holonom.app.recording import EPOCH, read_recording
from holonom.model import PRESETS

BASE = """
[cell]
name = "long"
time_limit = "24min"
seed = 3

[[robot]]
name = "agv"
arrangement = "omni"
angles = ["57deg", "135deg", "225deg", "303deg"]
radius = "79mm"
wheel_radius = "27mm"
mass = "6.4kg"
height = "40mm"
path = { shape = "circle", size = "2m", speed = "1m/s", acceleration = "2m/s2", laps = 100 }
"""
ARM = """
[cell]
name = "arm"
time_limit = "60s"
seed = 1

[[robot]]
name = "puma"
model = "puma560"
drives = "ideal"
program = "program.arps"
"""


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "holonom", *map(str, words)]


def started(folder: Path) -> tuple[subprocess.Popen[str], Path]:
    """A run of the long cell, once its recording grows."""
    (folder / "cell.toml").write_text(BASE, "utf-8")
    out = folder / "out"
    process = subprocess.Popen(
        command("run", folder / "cell.toml", "-o", out, "--quiet"),
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    recording = out / "recording.mcap"
    while process.poll() is None and not (recording.exists() and recording.stat().st_size > 50_000):
        time.sleep(0.01)
    return process, out


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_stopped_ends_in_order(tmp_path: Path, number: signal.Signals) -> None:
    """Motion stopped, recording closed; summary and report follow; status 130. On a machine of its own in 0.06 s."""
    process, out = started(tmp_path)
    begin = time.time()
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert (out / "recording.mcap").stat().st_mtime - begin < 1.0
    recording = read_recording(out / "recording.mcap")
    assert recording.ended == "complete"
    assert np.abs(recording.true_base.twist[-1]).max() < 0.1, "it was stopped"
    assert json.loads((out / "summary.json").read_text("utf-8"))["outcome"] == "stopped"
    assert (out / "report.html").stat().st_size > 100_000
    assert sorted(path.name for path in out.iterdir()) == ["recording.mcap", "report.html", "summary.json"]


def test_what_a_killed_run_leaves_is_read_and_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By our reader and by mcap's own, up to a moment before; and the next run is not kept out."""
    process, out = started(tmp_path)
    time.sleep(random.uniform(0.1, 0.6))
    process.kill()
    killed = time.time()
    process.communicate()
    path = out / "recording.mcap"
    assert killed - path.stat().st_mtime < 1.0
    recording = read_recording(path)
    assert recording.ended == "cut off"
    last = 0
    with path.open("rb") as file, suppress(EndOfFile, struct.error, IndexError):
        for _, _, message in NonSeekingReader(file).iter_messages(log_time_order=False):
            last = max(last, message.log_time - EPOCH)
    assert last / 1e9 == pytest.approx(recording.end(), abs=1e-6)
    assert main(["report", str(path), "-o", str(tmp_path / "told")]) == 0
    assert "cut off" in capsys.readouterr().out
    assert (tmp_path / "told" / "report.html").stat().st_size > 100_000


def test_a_second_run_is_refused_and_names_the_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    process, out = started(tmp_path)
    try:
        assert main(["run", str(tmp_path / "cell.toml"), "-o", str(out), "--quiet"]) == 2
        assert f"the run of process {process.pid}, begun 20" in capsys.readouterr().err
    finally:
        process.kill()
        process.communicate()


def arm_cell(folder: Path, program: str, more: str = "") -> Path:
    (folder / "program.arps").write_text(f".PROGRAM main()\n{program}\n.END\n", "utf-8")
    (folder / "cell.toml").write_text(ARM + more, "utf-8")
    return folder / "cell.toml"


def test_what_a_program_types_is_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = arm_cell(tmp_path, '  TYPE "hello"\n  DRIVE 1, 10, 50')
    assert main(["run", str(cell), "-o", str(tmp_path / "out")]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[0] == "hello"
    assert shown[1].startswith("arm: program ended after")
    assert "x real time" in shown[1]
    assert main(["run", str(cell), "-o", str(tmp_path / "out"), "--json"]) == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["outcome"] == "done"
    assert "hello" in shown.err


def test_a_program_at_pause_is_paused_not_done(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = arm_cell(tmp_path, "  DRIVE 1, 10, 50\n  PAUSE\n  DRIVE 1, 10, 50")
    assert main(["run", str(cell), "-o", str(tmp_path / "out"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["outcome"], said["failure"]) == ("paused", None)


def test_a_folder_of_a_finished_run_keeps_what_is_not_its_own(tmp_path: Path) -> None:
    cell, out = arm_cell(tmp_path, "  DRIVE 1, 5, 50"), tmp_path / "out"
    assert main(["run", str(cell), "-o", str(out), "--quiet"]) == 0
    (out / "notes.txt").write_text("mine", "utf-8")
    before = (out / "recording.mcap").read_bytes()
    assert main(["run", str(cell), "-o", str(out), "--quiet"]) == 0
    assert (out / "notes.txt").read_text("utf-8") == "mine"
    assert (out / "recording.mcap").read_bytes() == before
    assert sorted(path.name for path in out.iterdir()) == [
        "notes.txt", "recording.mcap", "report.html", "summary.json",
    ]  # fmt: skip


def test_a_controller_of_an_earlier_run_is_forgotten(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = 'controllers = ["cascade", "computed_torque"]'
    out = tmp_path / "out"
    cell = arm_cell(tmp_path, "  SIGNAL 1\n  DRIVE 1, 5, 50\n  BREAK\n  SIGNAL -1")
    text = cell.read_text("utf-8")
    cell.write_text(text.replace('drives = "ideal"', both), "utf-8")
    assert main(["run", str(cell), "-o", str(out), "--quiet"]) == 0
    assert (out / "recording_cascade.mcap").exists()
    (out / "recording_mine.mcap").write_text("not of a run", "utf-8")
    cell.write_text(text.replace('drives = "ideal"\n', ""), "utf-8")
    capsys.readouterr()
    assert main(["run", str(cell), "-o", str(out), "--quiet"]) == 0
    assert "cascade" not in capsys.readouterr().out
    assert not (out / "recording_cascade.mcap").exists()
    assert (out / "recording_mine.mcap").exists()


def test_a_summary_that_cannot_be_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell, out = arm_cell(tmp_path, "  DRIVE 1, 5, 50"), tmp_path / "out"
    (out / "summary.json").mkdir(parents=True)
    assert main(["run", str(cell), "-o", str(out), "--quiet"]) == 1
    told = capsys.readouterr().err
    assert told.startswith("holonom: error: cannot write ")
    assert "summary.json" in told
    assert read_recording(out / "recording.mcap").ended == "complete"


def test_a_disk_that_fills_up(tmp_path: Path) -> None:
    """A sentence, status 1, what was recorded kept."""
    (tmp_path / "cell.toml").write_text(BASE, "utf-8")

    def little() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))

    out = tmp_path / "out"
    environment = {**os.environ, "HOLONOM_CACHE": str(tmp_path / "none"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("HOLONOM_CACHE")
    done = subprocess.run(
        command("run", tmp_path / "cell.toml", "-o", out, "--quiet"),
        capture_output=True, text=True, check=False, preexec_fn=little, env=environment,
    )  # fmt: skip
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stderr
    assert "File too large" in done.stderr
    recording = read_recording(out / "recording.mcap")
    assert recording.end() > 0.5


def test_a_controller_and_a_sensor_of_another_package_run_from_a_cell(tmp_path: Path) -> None:
    """One file each, named by entry points: they are choices of the cell, and do their work."""
    (tmp_path / "spring.py").write_text(SPRING, "utf-8")
    (tmp_path / "height.py").write_text(HEIGHT, "utf-8")
    info = tmp_path / "throwaway-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: throwaway\nVersion: 1.0\n", "utf-8")
    points = "[holonom.controllers]\nspring = spring:METHOD\n\n[holonom.sensors]\nheight = height:METHOD\n"
    (info / "entry_points.txt").write_text(points, "utf-8")
    more = '\n[[sensor]]\nkind = "height"\nname = "gauge"\nrobot = "puma"\nnoise = 0.001\n'
    cell = arm_cell(tmp_path, "  COARSE ALWAYS\n  DRIVE 2, -10, 30", more)
    text = cell.read_text("utf-8").replace('drives = "ideal"', 'controllers = ["spring"]')
    cell.write_text(text, "utf-8")
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(
        command("run", cell, "-o", tmp_path / "out", "--json"),
        capture_output=True, text=True, check=False, env=environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    recording = read_recording(tmp_path / "out" / "recording.mcap", robot="puma")
    moved = recording.true_joints.position[-1] - recording.true_joints.position[0]
    np.testing.assert_allclose(np.degrees(moved), [0.0, -10.0, 0.0, 0.0, 0.0, 0.0], atol=0.2)  # friction holds it off
    track = read_recording(tmp_path / "out" / "recording.mcap", robot="").tracks["/measured/sensors/gauge"]
    height = recording.tool.position[:, 2]
    error = track.fields["values"][:, 0] - np.interp(track.time, recording.tool.time, height)
    assert 0.0005 < error.std() < 0.002
    listed = subprocess.run(
        command("methods", "sensors"), capture_output=True, text=True, check=True, env=environment
    ).stdout
    assert "height" in listed


SPRING = '''
from dataclasses import dataclass
import numpy as np
from holonom.registry import Method, parameter

@dataclass(frozen=True)
class Spring:
    """A spring and a damper on every joint, with the arm's own weight carried."""
    stiffness: float = parameter(2500.0, meaning="stiffness over inertia", unit="1/s2", above=0.0, most=1e4)

    def torques(self, arm, reference, position, speed, dt):
        k = self.stiffness
        u = reference[2] + k * (reference[0] - position) + 2 * np.sqrt(k) * (reference[1] - speed)
        return arm.inverse_dynamics(position, reference[1], u)

METHOD = Method("a spring and a damper per joint", lambda params: params, "a throw-away", Spring)
'''
HEIGHT = '''
from dataclasses import dataclass
from holonom.registry import Method, parameter

@dataclass(frozen=True)
class Height:
    """How high the tool is."""
    noise: float = parameter(0.0, meaning="standard deviation", least=0.0, most=1.0)

    def read(self, truth, rng):
        return truth.tool[2, 3] + self.noise * rng.standard_normal()

METHOD = Method("how high the tool is", lambda params: params, "a throw-away", Height)
'''


def run_each(folder: Path, names: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, str]:
    """Check and run each arm in a small cell, with the drives that it has and with ideal ones; say what failed."""
    failed: dict[str, str] = {}
    (folder / "first.arps").write_text(".PROGRAM main()\n  DRIVE 1, 5, 50\n.END\n", "utf-8")
    for name, drives in itertools.product(names, ("", 'drives = "ideal"\n')):
        robot = f"[[robot]]\nmodel = '{name}'\n{drives}program = 'first.arps'\n"
        (folder / "cell.toml").write_text(f'[cell]\nname = "arm"\ntime_limit = "20s"\nseed = 1\n\n{robot}', "utf-8")
        out = folder / "out"
        if main(["check", str(folder / "cell.toml")]) or main(["run", str(folder / "cell.toml"), "-o", str(out), "-q"]):
            failed[name] = capsys.readouterr().err
            continue
        recording = read_recording(out / "recording.mcap")
        moved = recording.true_joints.position[-1] - recording.true_joints.position[0]
        wanted = np.eye(len(moved))[0] * (
            0.005 if load_arm(name).model.joints[0].kind == "prismatic" else np.radians(5)
        )
        if np.abs(moved - wanted).max() > 2e-3:
            failed[name] = f"moved {moved}"
    return failed


def test_every_preset_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_each(tmp_path, list(PRESETS), capsys) == {}


def test_every_urdf_runs(tmp_path: Path, data_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    names = [str(path) for path in (data_folder / "robots" / "urdf").rglob("*.urdf")]
    assert names
    assert run_each(tmp_path, names, capsys) == {}
