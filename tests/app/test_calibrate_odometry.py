"""`holonom calibrate odometry`: numbers, notes, files and pictures; what cannot be calibrated is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from holonom.app.calibrate.odometry import TOPICS, calibrate_odometry
from holonom.app.odometry_log import OdometryLog, write_log
from holonom.app.odometry_log.recorded.truth_messages import poses_of
from holonom.errors import CalibrationError, LogError, UnknownName
from holonom.mobile.calibration import Run, drive_parameters
from holonom.mobile.odometry import integrate

NOMINAL = {"wheelbase": 0.2, "diameter_left": 0.084, "diameter_right": 0.084}
TRUTH = np.array([0.2008, 0.08404, 0.08396])


def square(sense: int) -> Run:
    """A square of 2 m that the nominal base believes to drive and the true one does."""
    straight = np.full((200, 2), 2.0 / 200 / 0.042)
    corner = np.tile(0.25 * np.pi * 0.2 / 0.042 / 100 * np.array([-sense, sense]), (100, 1))
    turns = np.concatenate([[[0.0, 0.0]], *([straight, corner] * 4)])
    matrix = drive_parameters("differential", NOMINAL).matrix(TRUTH)
    name = "left" if sense > 0 else "right"
    return Run(name, 0.05 * np.arange(len(turns)), turns, integrate(turns @ matrix.T), np.empty((len(turns), 0)))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    runs = tuple(square(sense) for sense in (-1, 1))
    return write_log(OdometryLog(tmp_path, "differential", NOMINAL, 2.0, runs), tmp_path / "log")


def test_umbmark_for_people_machines_and_files(log: Path, tmp_path: Path) -> None:
    answer = calibrate_odometry([log], drive="differential", method="umbmark", output=tmp_path / "out")
    assert answer.text.startswith("differential base, umbmark, 2 runs:")
    assert "unknown" in answer.text  # deviations of one run each way
    assert "note: squares: 1 clockwise, 1 counter-clockwise; 5 each way are usual" in answer.text
    data = json.loads((tmp_path / "out" / "odometry.json").read_text(encoding="utf-8"))
    assert data == json.loads(json.dumps(answer.data))
    assert data["nominal"] == NOMINAL
    assert data["calibrated"]["wheelbase"] == pytest.approx(0.2008, abs=1e-4)
    assert data["E_b"] == pytest.approx(1.004, abs=3e-4)
    assert data["deviations"]["wheelbase"] is None
    assert data["errors_after"]["max_final_distance_m"] < 0.1 * data["errors_before"]["max_final_distance_m"]
    assert data["errors_before"]["E_max_m"] == pytest.approx(data["errors_before"]["max_final_distance_m"])
    picture = (tmp_path / "out" / "odometry.png").read_bytes()
    assert picture[:4] == b"\x89PNG"


def test_runs_come_back_as_recordings(log: Path, tmp_path: Path) -> None:
    """As a log that calibrates to the same numbers, with truth and both odometries at every sample."""
    first = calibrate_odometry([log], output=tmp_path / "out", mcap=True)
    assert first.data["recordings"] == str(tmp_path / "out" / "log.toml")
    assert f"runs as MCAP: {tmp_path / 'out' / 'log.toml'}" in first.text
    again = calibrate_odometry([tmp_path / "out" / "log.toml"])
    assert again.data["calibrated"] == pytest.approx(first.data["calibrated"], abs=1e-6)
    ends = {topic: [] for topic in ("/odom", *TOPICS)}
    for path in sorted((tmp_path / "out").glob("*.mcap")):
        with path.open("rb") as stream:
            last = {channel.topic: message.data for _, channel, message in make_reader(stream).iter_messages()}
        for topic, found in ends.items():
            found.append(poses_of("nav_msgs/Odometry", [last[topic]], None, topic)[1][0])
    errors = {topic: np.hypot(*(np.array(found) - ends["/odom"])[:, :2].T).max() for topic, found in ends.items()}
    for topic, which in zip(TOPICS, ("before", "after"), strict=True):
        assert errors[topic] == pytest.approx(first.data[f"errors_{which}"]["max_final_distance_m"], abs=1e-9)
    with pytest.raises(CalibrationError, match="--mcap came without -o"):
        calibrate_odometry([log], mcap=True)


def test_least_squares_tells_both_sets(log: Path) -> None:
    data = calibrate_odometry([log]).data
    assert (data["drive"], data["method"], data["set"]) == ("differential", "least-squares", "extended")
    assert data["calibrated"] == pytest.approx(
        {**dict(zip(NOMINAL, TRUTH, strict=True)), "frame_ahead": 0.0, "frame_left": 0.0, "frame_yaw": 0.0}, abs=1e-6
    )
    assert data["physical"]["calibrated"] == pytest.approx(dict(zip(NOMINAL, TRUTH, strict=True)), abs=1e-6)
    assert data["E_d"] == pytest.approx(TRUTH[2] / TRUTH[1], abs=1e-6)
    assert set(data["deviations"]) == set(data["calibrated"])
    assert np.shape(data["matrix"]) == (3, 2)
    assert len(data["errors_after"]["runs"]) == 2
    plain = calibrate_odometry([log], parameters="physical").data
    assert plain["set"] == "physical"
    assert plain["calibrated"] == data["physical"]["calibrated"]


def test_straight_lines_fall_back_and_then_refuse(tmp_path: Path) -> None:
    run = square(1)
    line = Run("line", run.time[:200], run.turns[:200], run.truth[:200], run.steering[:200])
    path = write_log(OdometryLog(tmp_path, "differential", NOMINAL, None, (line,)), tmp_path / "line")
    with pytest.raises(CalibrationError, match="the motion tells nothing of wheelbase"):
        calibrate_odometry([path])


def test_what_cannot_be_calibrated_is_refused(log: Path, tmp_path: Path) -> None:
    one_way = write_log(OdometryLog(tmp_path, "differential", NOMINAL, 2.0, (square(1),)), tmp_path / "one")
    no_side = write_log(OdometryLog(tmp_path, "differential", NOMINAL, None, (square(1),)), tmp_path / "none")
    for arguments, problem, match in (
        ({"paths": [log], "drive": "tricycle"}, LogError, "is of a differential base; a tricycle was asked for"),
        ({"paths": [log], "drive": "trycicle"}, UnknownName, "did you mean 'tricycle'"),
        ({"paths": [log], "method": "umbmrak"}, UnknownName, "did you mean 'umbmark'"),
        ({"paths": [log], "parameters": "all"}, UnknownName, "there is extended, physical"),
        ({"paths": [one_way], "method": "umbmark"}, CalibrationError, "all counter-clockwise"),
        ({"paths": [no_side], "method": "umbmark"}, CalibrationError, "states no side"),
        ({"paths": [log], "held_out": True}, CalibrationError, "leaving one out needs three or more"),
        ({"paths": [log], "method": "umbmark", "held_out": True}, CalibrationError, "--held-out came with umbmark"),
        (
            {"paths": [log], "method": "umbmark", "parameters": "extended"},
            CalibrationError,
            "--parameters came with umbmark",
        ),
        ({"paths": [log], "form": "y"}, CalibrationError, "--form y came with least-squares"),
    ):
        arguments["output"] = tmp_path / "nothing"
        with pytest.raises(problem, match=match):
            calibrate_odometry(**arguments)
        assert not (tmp_path / "nothing").exists()


def test_sides_that_differ_are_named(log: Path, tmp_path: Path) -> None:
    other = replace(square(1), time=square(1).time + 1.0)
    path = write_log(OdometryLog(tmp_path, "differential", NOMINAL, 1.5, (other,)), tmp_path / "other")
    with pytest.raises(CalibrationError, match=r"squares of sides 2, 1.5 m came"):
        calibrate_odometry([log, path], method="umbmark")


def slipping(folder: Path, factor: float) -> Path:
    good, bad = square(1), square(-1)
    turns = bad.turns + 0.0
    turns[150:250, 0] *= factor
    runs = (good, replace(bad, turns=turns))
    return write_log(OdometryLog(folder, "differential", NOMINAL, 2.0, runs), folder / "log")


def test_a_run_that_stays_astray_is_noted(tmp_path: Path) -> None:
    """A wheel that slips for a while: the line in the log, and the distance that no calibration takes away."""
    notes = calibrate_odometry([slipping(tmp_path / "a", 1.3)]).data["notes"]
    assert any("002-right.csv:1" in note and "the wheels move more than the truth" in note for note in notes)
    assert any(note.startswith("run 002-right is still") and "not to be trusted" in note for note in notes)
    with pytest.raises(CalibrationError, match=r"(?s)does not tell .*note: .*002-right.csv:1.* the wheels move more"):
        calibrate_odometry([slipping(tmp_path / "b", 4.0)])


PUBLISHED = [  # OptiOdom, published_results: errors before calibration, those of headings for all drives
    ("diff/square/230620202042", "umbmark", (0.035057, 4.66003, 0.033256, 3.302042)),
    ("diff/square/231220200045", "umbmark", (0.101571, 7.230344, 0.10144, 5.457208)),
    ("tricyc/circular/140120211440", "least-squares", (1.236681, 107.129424, 1.077603, 101.338803)),
    ("tricyc/square/140120211446", "least-squares", (1.260309, 83.95621, 1.221647, 60.507896)),
    ("omni3/circular/221220201730", "least-squares", (None, 7.112191, None, 6.478107)),
    ("omni4/circular/231220200510", "least-squares", (None, 8.868256, None, 7.851371)),
]


@pytest.mark.parametrize(("folder", "method", "before"), PUBLISHED, ids=[p[0] for p in PUBLISHED])
def test_published_sets_from_the_folder(data_folder: Path, folder: str, method: str, before) -> None:
    answer = calibrate_odometry([data_folder / "odometry" / "optiodom" / folder], method=method)
    keys = ("max_distance_m", "max_heading_deg", "max_final_distance_m", "max_final_heading_deg")
    for key, number in zip(keys, before, strict=True):
        if number is not None:
            assert answer.data["errors_before"][key] == pytest.approx(number, abs=1e-6), key
        assert answer.data["errors_after"][key] < answer.data["errors_before"][key]
    assert any("N names 4 runs, 2 are here" in note for note in answer.data["notes"]) == folder.startswith("omni4")


def test_umbmark_is_for_differential_drives(data_folder: Path) -> None:
    with pytest.raises(CalibrationError, match="UMBmark is for differential drives; for an omni3"):
        calibrate_odometry([data_folder / "odometry" / "optiodom" / "omni3"], method="umbmark")


def test_held_out_errors_are_told(data_folder: Path) -> None:
    folder = data_folder / "odometry" / "optiodom" / "diff" / "square" / "230620202042"
    answer = calibrate_odometry([folder], held_out=True, parameters="extended")
    held, before = answer.data["errors_held_out"], answer.data["errors_before"]
    assert held["max_distance_m"] < 0.5 * before["max_distance_m"]
    assert "held out" in answer.text


def test_limits_are_kept_or_refused(log: Path) -> None:
    free = calibrate_odometry([log], limits=[np.inf] * 4).data
    assert free["limits"] == dict.fromkeys(free["limits"])
    data = calibrate_odometry([log], limits=[np.inf, 1.0, np.inf, 0.5]).data
    assert data["limits"]["max_heading_deg"] == pytest.approx(1.0)
    assert data["errors_after"]["max_heading_deg"] <= 1.0
    assert data["errors_after"]["max_final_heading_deg"] <= 0.5
    with pytest.raises(CalibrationError, match="--limits came with umbmark"):
        calibrate_odometry([log], method="umbmark", limits=[np.inf] * 4)
