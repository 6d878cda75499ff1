"""A base's cell, run: what the summary claims is in the recording, the faults are found, the report shows them."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from holonom.app.base.assembly import build_job, simulate
from holonom.app.base.outcome import dead_motors, path_errors, slip_episodes
from holonom.app.cell import load_cell
from holonom.app.cli import main
from holonom.app.recording import read_recording
from holonom.errors import CellError

SOCCER = Path(__file__).resolve().parents[2] / "examples" / "03_soccer_robot" / "cell.toml"
JOB = build_job(load_cell(SOCCER), SOCCER)


@pytest.fixture(scope="module")
def run(example_run: Callable[[str], Path]) -> Path:
    return example_run("03_soccer_robot")


def summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text("utf-8"))


def test_the_wheel_on_ice_is_found_and_named(run: Path) -> None:
    said = summary(run)
    slips = [slip for slip in said["slips"] if slip["start"] < said["dead_motors"][0]["time"]]
    assert slips
    for slip in slips:
        assert slip["delay"] is not None, slip
        assert slip["delay"] < 0.05
        assert slip["named"] == [slip["wheel"]]
    for slip in said["slips"]:  # with a dead motor too, no wheel is named wrongly
        assert slip["named"] in ([], [slip["wheel"]])


def test_the_dead_motor_is_found_and_made_up_for(run: Path) -> None:
    said = summary(run)
    (motor,) = said["dead_motors"]
    fault = JOB.cell.faults[0]
    assert (motor["wheel"], motor["time"]) == (fault.wheel, fault.time)
    assert 0.0 < motor["detected"] - motor["time"] < 0.2
    error = next(error for error in said["path_errors"] if error["phase"] == f"{fault.wheel}: motor dead")
    assert error["peak_m"] < 0.3 * error["peak_without_handling_m"]
    assert error["believed_peak_m"] < 0.03


def test_the_summary_is_what_the_recording_says(run: Path) -> None:
    recording = read_recording(run / "recording.mcap")
    said = summary(run)["path_errors"][0]
    true = recording.frames["base_link"]
    wanted = np.array([np.interp(true.time, recording.base_reference.time, x) for x in recording.base_reference.pose.T])
    error = np.hypot(*(true.position[:, :2].T - wanted[:2]))
    assert np.sqrt(np.mean(error**2)) == pytest.approx(said["rms_m"], rel=0.02)
    assert error.max() == pytest.approx(said["peak_m"], rel=0.02)
    assert recording.joint_names == JOB.base.driven
    believed = np.hypot(*(recording.base.pose[:, :2] - recording.base_reference.pose[:, :2]).T)
    assert believed.max() < said["peak_m"]  # the controller closes its loop on what it believes
    slips = [signal for signal in recording.signals if signal.number == 1]
    assert [signal.on for signal in slips[:2]] == [True, False]


def test_wheels_stand_on_the_base(run: Path) -> None:
    recording = read_recording(run / "recording.mcap")
    base, wheels = recording.frames["base_link"].poses(), [f"wheel_{k}" for k in range(1, 5)]
    for name, wheel in zip(wheels, JOB.base.wheels, strict=True):
        local = np.linalg.inv(base) @ recording.frames[name].poses()
        assert np.allclose(local[:, :3, 3], [wheel.x, wheel.y, wheel.radius], atol=1e-9)
        assert np.allclose(local[:, 2, 1], 0.0, atol=1e-9)  # the axle stays level


def test_report_shows_faults_and_polar_plots(run: Path) -> None:
    page = (run / "report.html").read_text("utf-8")
    for section in ("path", "faults", "polar", "curves", "limits", "log"):
        assert f'<section id="{section}"' in page
    assert page.count('<figure class="polar">') == 3
    rows = re.findall("<tr>" + 5 * "<td>([^<]*)</td>" + "</tr>", page)
    said = summary(run)
    assert len(rows) == len(said["slips"]) + len(said["dead_motors"])
    assert rows[0][4] == said["slips"][0]["wheel"]
    assert rows[-1][4] == said["dead_motors"][0]["wheel"]


def test_same_seed_same_bytes(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(SOCCER), "-o", str(tmp_path / "again"), "--quiet"]) == 0
    again = tmp_path / "again" / "recording.mcap"
    assert again.read_bytes() == (run / "recording.mcap").read_bytes()
    assert main(["run", str(SOCCER), "-o", str(tmp_path / "other"), "--seed", "99", "--quiet"]) == 0
    assert (tmp_path / "other" / "recording.mcap").read_bytes() != again.read_bytes()
    assert "front" in capsys.readouterr().out


def test_without_ice_and_faults_nothing_is_found() -> None:
    """The detector keeps still on a good floor, however the noise falls."""
    floor = JOB.cell.floor.model_copy(update={"patches": ()})
    for seed in range(5):
        about = JOB.cell.cell.model_copy(update={"seed": seed})
        cell = JOB.cell.model_copy(update={"floor": floor, "faults": (), "cell": about})
        job = build_job(cell, SOCCER)
        log = simulate(job)
        assert slip_episodes(log, job.floor) == []
        assert dead_motors(log, job.faults) == []
        assert not log.named.any()
        assert not log.dead.any()
        error = path_errors(log, [], [])[0]
        assert error.believed < 0.02
        assert error.peak < 0.1  # 20 s of dead reckoning with a gyro that is 0.2 deg/s off


def test_a_mecanum_base_drives_a_square(tmp_path: Path) -> None:
    text = SOCCER.read_text("utf-8")
    text = re.sub(r'arrangement = "omni"\nangles.*?\nwheels.*?\nradius.*?\n',
                  'arrangement = "mecanum"\nwheelbase = "150mm"\ntrack = "150mm"\n', text, flags=re.DOTALL)  # fmt: skip
    text = re.sub(r"\[\[floor.*?\n\n|\[\[faults.*", "", text, flags=re.DOTALL)
    text = text.replace('"figure_of_eight"', '"rounded_square"').replace('"fixed"', '"tangent"')
    path = tmp_path / "cell.toml"
    path.write_text(text.replace('speed = "2m/s"', 'speed = "0.8m/s"').replace('size = "5m"', 'size = "1.5m"'), "utf-8")
    job = build_job(load_cell(path), path)
    assert job.base.driven[0] == "front left"
    log = simulate(job)
    assert path_errors(log, [], [])[0].believed < 0.03
    assert log.path_error.max() < 0.15


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('time_limit = "60s"', 'time_limit = "3s"', "cell.time_limit: the path takes"),
        ('"57deg", "135deg", "225deg", "303deg"', '"57deg", "57deg", "57deg", "57deg"', ": base: "),
        ('wheel = "rear left"', 'wheel = "left"', "did you mean"),
    ],
)
def test_what_does_not_go_together_is_named_before_anything_is_written(
    tmp_path: Path, old: str, new: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = tmp_path / "cell.toml", tmp_path / "out"
    text = SOCCER.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    with pytest.raises(CellError, match=re.escape(says)):
        build_job(load_cell(path), path)
    assert main(["run", str(path), "-o", str(out)]) == 2
    assert says in capsys.readouterr().err
    assert not out.exists()


def test_check_says_what_the_path_takes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(SOCCER), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["warnings"] == []
    assert 0.0 < said["peak_wheel_speed_rad_s"] < said["wheel_speed_limit_rad_s"]
    assert said["estimated_time_s"] < 60.0
