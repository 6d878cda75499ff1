"""`holonom calibrate dynamics`: from a recording to numbers, for people, machines and files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from holonom.app.console.cli import main
from holonom.app.recording import Recorder, read_recording
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.identification import excitation
from holonom.mechanics.identification.columns import parameters, regressor_of_rows
from holonom.signals import JointState


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A planar arm's exciting motion with noisy torques, as a run would record it."""
    arm: Arm = load_arm("planar2r")
    motion = excitation(arm, trials=3, duration=20.0, dt=0.005).trajectory
    tau = regressor_of_rows(arm.model)(motion.q, motion.qd, motion.qdd) @ parameters(arm.model)
    tau += np.random.default_rng(0).normal(0.0, 2.0, tau.shape)
    path = tmp_path_factory.mktemp("record") / "recording.mcap"
    with Recorder(path, [joint.name for joint in arm.model.joints]) as recorder:
        for k, (q, qd, effort) in enumerate(zip(motion.q, motion.qd, tau, strict=True)):
            recorder.put(JointState(0.005 * k, q, qd, effort))
    return path


def test_a_recording_gives_the_arm(recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["calibrate", "dynamics", str(recording), "--arm", "planar2r", "--no-friction", "-o", str(tmp_path)]
    assert main(command) == 0
    text = capsys.readouterr().out
    assert text.startswith("7 base parameters of planar2r")
    assert "without effect on any torque: hz1, " in text
    assert main([*command, "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data == json.loads((tmp_path / "dynamics.json").read_text(encoding="utf-8"))
    found = {entry["name"]: entry for entry in data["base_parameters"]}
    assert found["hx2"]["formula"] == "hx2 + m2"
    assert abs(found["hx2"]["value"] - 25.0) < 4 * found["hx2"]["deviation"] < 1.0  # 50 kg, half of 1 m before the end
    assert [body["joint"] for body in data["bodies"]] == ["joint1", "joint2"]
    assert data["doubts"] == []
    assert "warning" not in text


def test_a_joint_of_wrong_sign_is_warned_of(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    track = read_recording(recording).joints
    with Recorder(tmp_path / "turned.mcap", ["joint1", "joint2"]) as recorder:
        for t, q, qd, tau in zip(track.time, track.position, track.velocity, track.effort, strict=True):
            recorder.put(JointState(t, q * [1.0, -1.0], qd * [1.0, -1.0], tau))
    command = ["calibrate", "dynamics", str(tmp_path / "turned.mcap"), "--arm", "planar2r", "--no-friction"]
    assert main(command) == 0
    assert "\nwarning: no arm of this kind explains the record" in capsys.readouterr().out
    assert main([*command, "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["doubts"]) >= 1


def test_what_cannot_be_calibrated_is_refused(recording: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["calibrate", "dynamics", str(recording), "--arm"]
    assert main([*command, "puma560"]) == 2
    assert "holds positions of 2 joints and torques of 2; arm 'puma560' has 6" in capsys.readouterr().err
    assert main([*command, "scara"]) == 2
    assert "arm 'scara' has 4" in capsys.readouterr().err
    assert main([*command, "puma"]) == 2
    assert "did you mean 'puma560'" in capsys.readouterr().err
    assert main([*command, "planar2r", "--cutoff", "500"]) == 2
    assert "give one above 0 and up to 50" in capsys.readouterr().err
    assert main(["calibrate", "dynamics", "absent.mcap", "--arm", "planar2r"]) == 2
    assert "cannot read the recording absent.mcap" in capsys.readouterr().err
