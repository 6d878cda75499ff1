"""A base's cell, run: what the summary claims is in the recording, the faults are found, the report shows them."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rig_runs import record

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.app.console.cli import main
from holonom.app.recording import read_recording
from holonom.app.report.findings.base_findings import Phase, findings_of, motion_of, path_error
from holonom.errors import CellError
from holonom.sim import Floor

SOCCER = Path(__file__).resolve().parents[2] / "examples" / "03_soccer_robot" / "cell.toml"
CELL = build_job(load_cell(SOCCER), SOCCER)
JOB = CELL.bases[0]


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
        assert slip["naming_delay"] is not None, slip
        assert 0.0 <= slip["delay"] <= slip["naming_delay"] < 0.05
        assert slip["named"] == [slip["wheel"]]
    assert not [alarm for alarm in said["false_alarms"] if "named" in alarm["what"] or "given up" in alarm["what"]]


def test_the_dead_motor_is_found_and_made_up_for(run: Path) -> None:
    said = summary(run)
    (motor,) = said["dead_motors"]
    fault = JOB.faults[0]
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
    assert [signal.on for signal in slips[:3]] == [False, True, False]
    assert slips[0].time == 0.0


def test_every_signal_is_what_its_name_says(run: Path) -> None:
    """Measured from what sensors gave, commanded from what the controller asked, truth from the plant alone."""
    recording = read_recording(run / "recording.mcap")
    motor = 2.0 * np.pi / JOB.drive.encoder.counts_per_rev / JOB.drive.gear.ratio
    measured, true, asked = recording.joints, recording.true_joints, recording.reference
    assert np.allclose(measured.position, motor * (recording.counts.count + 0.5))
    assert 0.0 < np.abs(measured.position - true.position).max() <= motor
    assert np.abs(measured.velocity - true.velocity).max() > 0.0
    assert not np.array_equal(asked.velocity, measured.velocity)
    step = np.diff(asked.position, axis=0) / np.diff(asked.time)[:, None]
    assert np.abs(step - asked.velocity[:-1]).mean() < 0.05 * np.abs(asked.velocity).mean()
    assert np.abs(asked.position[-1] - true.position[-1]).max() > 0.1  # no copy of the truth
    torque = JOB.drive.motor.torque_constant * JOB.drive.gear.ratio
    assert np.allclose(measured.effort, torque * recording.drives.current)
    noise = recording.drives.current - recording.tracks["/truth/motor_current"].fields["current"]
    assert 0.02 < noise.std() < 0.04  # the shunt's
    assert np.allclose(recording.true_base.pose[:, :2], recording.frames["base_link"].position[:, :2])
    assert np.allclose(recording.base.pose[:, :2], recording.tree["odom", "base_link"].position[:, :2])
    assert not recording.tree["map", "odom"].position.any()
    assert recording.ended == "complete"


def test_the_recording_says_how_sure_the_base_is(run: Path) -> None:
    base = read_recording(run / "recording.mcap").base
    sure = np.sqrt(np.einsum("kii->ki", base.covariance))
    assert (sure > 0.0).all()
    assert (sure[-1] > 10.0 * sure[0]).all()
    assert np.linalg.eigvalsh(base.covariance).min() > 0.0


def test_an_hour_stays_below_a_gigabyte(run: Path) -> None:
    path = run / "recording.mcap"
    assert path.stat().st_size / read_recording(path).end() * 3600.0 < 1e9


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
    slips, dead = len(said["slips"]), len(said["dead_motors"])
    assert len(rows) == slips + dead + len(said["false_alarms"])
    assert rows[0][4] == said["slips"][0]["wheel"]
    assert rows[slips][4] == said["dead_motors"][0]["wheel"]


SHORT = """[cell]
name = "short"
time_limit = "3s"
[[robot]]
arrangement = "omni"
angles = ["60deg", "180deg", "300deg"]
radius = "200mm"
wheel_radius = "50mm"
mass = "20kg"
velocity = [{ at = "0s", vx = "0.5m/s", w = "1rad/s" }, { at = "1.8s" }, { at = "2s" }]
"""


def test_same_seed_same_bytes(tmp_path: Path) -> None:
    """Two seconds of a robot, twice by one seed and once by another."""
    path = tmp_path / "cell.toml"
    path.write_text(SHORT, "utf-8")
    seen = []
    for name, more in (("one", []), ("again", []), ("other", ["--seed", "99"])):
        assert main(["run", str(path), "-o", str(tmp_path / name), "--quiet", *more]) == 0
        seen.append((tmp_path / name / "recording.mcap").read_bytes())
    assert seen[0] == seen[1]
    assert seen[0] != seen[2]


def test_without_ice_and_faults_nothing_is_found(tmp_path: Path) -> None:
    """The detector keeps still on a good floor, however the noise falls."""
    for seed in range(3):
        job = dataclasses.replace(
            CELL, seed=seed, floor=Floor(CELL.floor.material), bases=(dataclasses.replace(JOB, faults=()),)
        )
        source = record(job, tmp_path / f"{seed}.mcap")
        robot = source.robots[0]
        found = findings_of(robot.recording, robot.facts)
        assert (found.slips, found.dead, found.alarms) == ((), (), ())
        assert [event.text for event in source.events] == ["path driven"]
        error = path_error(motion_of(robot.recording), Phase("all", 0.0, 1e3))
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
    assert job.bases[0].base.driven[0] == "front left"
    error = path_error(motion_of(record(job, tmp_path / "r.mcap").robots[0].recording), Phase("all", 0.0, 1e3))
    assert error.believed < 0.03
    assert error.peak < 0.15


def edited(folder: Path, *changes: tuple[str, str]) -> Path:
    text = SOCCER.read_text("utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "cell.toml").write_text(text, "utf-8")
    return folder / "cell.toml"


def run_edited(folder: Path, *changes: tuple[str, str]) -> tuple[int, dict]:
    path = edited(folder, *changes, ("laps = 2", "laps = 1"))
    status = main(["run", str(path), "-o", str(folder / "out"), "--quiet"])
    assert (folder / "out" / "report.html").exists()
    return status, summary(folder / "out")


FAULT = 'time = "13s"\nkind = "motor_dead"\nwheel = "rear left"'
PLACE = 'centre = ["2.14m", "1.205m"]\nsize = ["300mm", "50mm"]\nangle = "-37deg"'


@pytest.mark.parametrize("place", [(-2.14, -1.205), (0.0, 0.0), (2.3, 1.0), (-1.0, 1.0), (2.5, 0.0), (9.0, 9.0)])
def test_ice_anywhere_is_told_truly(tmp_path: Path, place: tuple[float, float]) -> None:
    centre = f'centre = ["{place[0]}m", "{place[1]}m"]\nsize = ["600mm", "600mm"]'
    status, said = run_edited(tmp_path, (PLACE, centre), (FAULT, FAULT.replace("13s", "100s")))
    assert status == (0 if said["failure"] is None else 1)
    assert said["path_errors"][0]["peak_m"] is not None
    (motor,) = said["dead_motors"]
    assert (motor["reached"], motor["detected"]) == (False, None)
    for slip in said["slips"]:
        assert slip["right"] == (slip["named"] == [slip["wheel"]])


@pytest.mark.parametrize("time", ["0s", "1s", "3s"])
def test_a_motor_that_dies_early_is_made_up_for(tmp_path: Path, time: str) -> None:
    status, said = run_edited(tmp_path, (FAULT, FAULT.replace("13s", time)))
    assert (status, said["failure"], said["path_driven"]) == (0, None, pytest.approx(1.0, abs=1e-3))
    assert said["dead_motors"][0]["detected"] is not None


def test_a_base_that_stops_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    blocked = FAULT.replace("13s", "3s").replace("motor_dead", "motor_blocked")
    status, said = run_edited(tmp_path, (FAULT, blocked))
    assert status == 1
    assert said["outcome"] == "failed"
    assert 0.05 < said["path_driven"] < 0.9
    told = capsys.readouterr().err
    assert "stopped with a jammed wheel after" in told
    assert "% of the path" in told
    assert 'class="outcome bad"' in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_a_run_longer_than_its_time_says_so(tmp_path: Path) -> None:
    changes = (FAULT, FAULT.replace("13s", "2s")), ('time_limit = "60s"', 'time_limit = "11.5s"')
    status, said = run_edited(tmp_path, *changes)
    assert status == 1
    assert "not done after 11.5 s of simulated time, the cell's time_limit" in said["failure"]


@pytest.mark.parametrize(
    ("change", "warning"),
    [
        (('max_current = "8A"', 'max_current = "100mA"'), "more force than the motors have"),
        (('height = "40mm"', 'height = "400mm"'), "tips over"),
        (("friction = 0.8\nsliding_friction = 0.65", "friction = 0.1\nsliding_friction = 0.08"), "floor takes"),
        ((FAULT, FAULT.replace("13s", "90s")), "fault of rear left at 90 s: the path is driven in"),
    ],
)
def test_check_warns_of_what_the_path_asks(
    tmp_path: Path, change: tuple[str, str], warning: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(edited(tmp_path, change)), "--json"]) == 0
    assert warning in " ".join(json.loads(capsys.readouterr().out)["warnings"])


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
