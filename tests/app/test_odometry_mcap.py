"""Logs of odometry in MCAP: a peer reads them, they come back, and broken ones are refused in one line."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest

from holonom.app.odometry_log import OdometryLog, read_log, write_log
from holonom.errors import LogError
from holonom.mobile.calibration import Run, dead_reckoning, drive_parameters
from holonom.mobile.odometry import integrate

TIME = 0.05 * np.arange(200)
DIFFERENTIAL = {"wheelbase": 0.2, "diameter_left": 0.084, "diameter_right": 0.084}


def differential() -> Run:
    """Left wheel slower, then faster: an S."""
    turns = np.stack([0.06 + 0.03 * np.sin(0.4 * TIME), 0.09 - 0.01 * np.sin(0.4 * TIME)], axis=1)
    turns[0] = 0.0
    p = drive_parameters("differential", DIFFERENTIAL)
    return Run("s", TIME, turns, integrate(turns @ p.matrix(p.nominal).T), np.empty((200, 0)))


def test_a_peer_reads_what_is_written_to_mcap(tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap_ros2.reader", reason="pip install mcap-ros2-support")
    run = differential()
    write_log(OdometryLog(tmp_path, "differential", DIFFERENTIAL, None, (run,)), tmp_path, runs="mcap")
    messages = list(reader.read_ros2_messages(str(tmp_path / "001-s.mcap")))
    odometry = [m.ros_msg for m in messages if m.channel.topic == "/odom"]
    joints = [m.ros_msg for m in messages if m.channel.topic == "/joint_states"]
    assert joints[-1].name == ["left", "right"]
    assert np.allclose(joints[-1].position, run.turns.sum(axis=0))
    last = odometry[-1].pose.pose
    assert np.allclose([last.position.x, last.position.y], run.truth[-1, :2])
    assert 2 * np.arctan2(last.orientation.z, last.orientation.w) == pytest.approx(run.truth[-1, 2])


def test_mcap_faults_and_names(tmp_path: Path) -> None:
    log = OdometryLog(tmp_path, "differential", DIFFERENTIAL, None, (differential(),))
    toml = write_log(log, tmp_path, runs="mcap")
    text = toml.read_text()
    toml.write_text(text + '[mcap]\njoints = "/joint_states"\nnames = { left = "right", right = "left" }\n')
    with pytest.raises(LogError, match="are swapped"):
        read_log([toml])
    toml.write_text(text + '[mcap]\nnames = { left = "wheel" }\n')
    with pytest.raises(LogError, match="no joint wheel; there is left, right"):
        read_log([toml])
    toml.write_text(text + '[mcap]\njoints = "/other"\n')
    with pytest.raises(LogError, match="no sensor_msgs/JointState messages"):
        read_log([toml])
    toml.write_text(text + '[mcap]\ntruth = "/other"\n')
    assert len(read_log([toml]).runs[0].truth) == 0
    toml.write_text(text)
    whole = (tmp_path / "001-s.mcap").read_bytes()
    for broken in (b"nothing of the kind", b"", whole[:5]):
        (tmp_path / "001-s.mcap").write_bytes(broken)
        with pytest.raises(LogError, match="is no MCAP recording"):
            read_log([toml])
    (tmp_path / "001-s.mcap").write_bytes(whole[:30])
    with pytest.raises(LogError, match="no sensor_msgs/JointState messages"):
        read_log([toml])


def test_a_cut_mcap_log_gives_what_is_there(tmp_path: Path) -> None:
    """Every sample before the cut, and a note; a chunk of a file that was copied in part has no checksum."""
    one = differential()
    many = Run(
        "s", *(np.concatenate([part] * 40) for part in (one.time, one.turns)), np.empty((0, 3)), np.empty((8000, 0))
    )
    many = Run(many.name, 0.1 * np.arange(8000.0), many.turns, many.truth, many.steering)
    toml = write_log(OdometryLog(tmp_path, "differential", DIFFERENTIAL, None, (many,)), tmp_path, runs="mcap")
    path = tmp_path / "001-s.mcap"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    log = read_log([toml])
    count = len(log.runs[0].time)
    assert 1000 < count < 8000
    assert np.allclose(log.runs[0].turns, many.turns[:count])
    assert any(re.search(r"is damaged or cut off, missing is from [\d.]+ s on: it ends", note) for note in log.notes)


def test_damaged_mcap_files_end_in_one_line(tmp_path: Path) -> None:
    """One byte changed anywhere: read all the same, or refused as a log."""
    toml = write_log(
        OdometryLog(tmp_path, "differential", DIFFERENTIAL, None, (differential(),)), tmp_path, runs="mcap"
    )
    whole, rng = (tmp_path / "001-s.mcap").read_bytes(), np.random.default_rng(4)
    for at in rng.integers(len(whole), size=60):
        broken = bytearray(whole)
        broken[at] ^= 0x55
        (tmp_path / "001-s.mcap").write_bytes(broken)
        with contextlib.suppress(LogError):
            read_log([toml])


def test_turns_of_the_first_sample_are_not_lost_in_mcap(tmp_path: Path) -> None:
    run = differential()
    turns = run.turns + 0.0
    turns[0] = 0.05
    moving = Run("m", run.time + 1.0, turns, run.truth, run.steering)
    log = OdometryLog(tmp_path, "differential", DIFFERENTIAL, None, (moving,))
    back = read_log([write_log(log, tmp_path, runs="mcap")]).runs[0]
    assert np.allclose(back.turns, np.vstack([[0.0, 0.0], turns]))
    assert np.allclose(back.time[1:], moving.time)
    assert np.allclose(back.truth[1:], moving.truth)
    M = drive_parameters("differential", DIFFERENTIAL).matrix(np.array(list(DIFFERENTIAL.values())))
    assert np.allclose(dead_reckoning(back, M)[1:], dead_reckoning(moving, M))
