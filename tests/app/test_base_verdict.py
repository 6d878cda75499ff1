"""A verdict looks at the task: where the base truly was, whether it stands, what it can hold with motors lost."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

import numpy as np
import pytest
from cell_files import built

from holonom.app.cell.check import check_cell
from holonom.app.recording import read_recording
from holonom.app.report.findings.headline import badge_of
from holonom.app.report.source import source_of
from holonom.app.rig.base import make_base
from holonom.app.rig.path_judge import PathJudge
from holonom.app.run import run_cell
from holonom.errors import CellError, DriveFault
from holonom.sim import Floor

CELL = """
[cell]
name = "omni"
seed = 3
time_limit = "60s"
[base]
arrangement = "omni"
{wheels}
radius = "79mm"
wheel_radius = "27mm"
mass = "6kg"
height = "{height}"
{com}
[floor]
friction = {friction}
sliding_friction = {sliding}
[path]
shape = "circle"
size = "1m"
speed = "{speed}m/s"
acceleration = "1.2m/s2"
{path}
{faults}
"""
FOUR = 'angles = ["57deg", "135deg", "225deg", "303deg"]\nwheels = ["a", "b", "c", "d"]'
THREE = 'angles = ["60deg", "180deg", "300deg"]\nwheels = ["a", "b", "c"]'
DEAD = '[[faults]]\ntime = "1s"\nkind = "motor_dead"\nwheel = "b"\n'


def cell(folder: Path, **changes: object) -> Path:
    words = {
        "wheels": FOUR,
        "height": "0mm",
        "com": "",
        "friction": 0.8,
        "sliding": 0.6,
        "path": "",
        "faults": "",
        "speed": 0.8,
    }
    path = folder / "cell.toml"
    path.write_text(CELL.format(**(words | changes)), encoding="utf-8")
    return path


def test_a_path_that_is_kept_is_done(tmp_path: Path) -> None:
    answer = run_cell(cell(tmp_path), tmp_path / "out")
    assert answer.data["outcome"] == "done"
    assert answer.data["path_driven"] == pytest.approx(1.0, abs=1e-3)
    assert badge_of(source_of(tmp_path / "out" / "recording.mcap")).tone == "ok"


def test_a_path_on_ice_has_failed_whatever_the_controller_believes(tmp_path: Path) -> None:
    """The true pose counts; summary, recording and the report of the recording agree."""
    with pytest.raises(
        DriveFault, match=r"the path was not kept: .* m off at .* s, 0.05 m are allowed.*within its tol"
    ):
        run_cell(cell(tmp_path, friction=0.06, sliding=0.04), tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["outcome"] == "failed"
    recording = read_recording(tmp_path / "out" / "recording.mcap")
    true, wanted = recording.true_base, recording.base_reference
    far = np.hypot(*(true.pose[:, :2] - wanted.pose[: len(true.time), :2]).T)
    assert far.max() > 0.05  # 5 % of the larger side of the path's box
    steps = np.hypot(*np.diff(wanted.pose[: len(far), :2], axis=0).T)
    assert summary["path_driven"] == pytest.approx(steps[far[1:] <= 0.05].sum() / steps.sum(), abs=0.05)
    badge = badge_of(source_of(tmp_path / "out" / "recording.mcap"))
    assert badge.tone == "bad"
    assert "the path was not kept" in badge.text


def test_tolerances_of_the_cell(tmp_path: Path) -> None:
    wide = 'position_tolerance = "50m"\nheading_tolerance = "180deg"'
    assert run_cell(cell(tmp_path, friction=0.06, sliding=0.04, path=wide), tmp_path / "a").data["outcome"] == "done"
    with pytest.raises(DriveFault, match=r"m off at .*, 0.0001 m are allowed"):
        run_cell(cell(tmp_path, path='position_tolerance = "0.1mm"'), tmp_path / "b")
    with pytest.raises(CellError, match="position_tolerance"):
        run_cell(cell(tmp_path, path='position_tolerance = "0mm"'), tmp_path / "c")
    with pytest.raises(CellError, match="keep: no setting 'pth'"):
        run_cell(cell(tmp_path, path='keep = "pth"'), tmp_path / "d")


def test_two_wheels_hold_path_or_heading_as_the_cell_chooses(tmp_path: Path) -> None:
    lame = {"wheels": THREE, "faults": DEAD, "speed": 0.4}
    warned = check_cell(cell(tmp_path, **lame)).data["warnings"]
    assert any("without the motor of b, from 1 s on, the others cannot hold path and heading" in w for w in warned)
    with pytest.raises(DriveFault, match="the path was not kept"):
        run_cell(cell(tmp_path, **lame), tmp_path / "both")
    events = [event.text for event in read_recording(tmp_path / "both" / "recording.mcap").events]
    assert any("cannot hold path and heading at once, both are asked for" in text for text in events)
    for keep, given_up in (("path", "heading"), ("heading", "path")):
        chosen = cell(tmp_path, **lame, path=f'keep = "{keep}"')
        assert not [w for w in check_cell(chosen).data["warnings"] if "cannot hold" in w]
        answer = run_cell(chosen, tmp_path / keep)
        assert f"path driven, {given_up} given up for want of motors" in answer.text
        last = answer.data["path_errors"][-1]
        assert (last["peak_m"] < 0.05) == (keep == "path")
        assert (last["heading_peak_rad"] < np.radians(10.0)) == (keep == "heading")


def test_a_tall_base_tips_where_check_says_it_will(tmp_path: Path) -> None:
    """com height over half the support against a / g: tips in the curve, at v^2 / r = 1.2 m/s2 and 0.5 m."""
    tall = cell(tmp_path, height="600mm")
    (warning,) = [w for w in check_cell(tall).data["warnings"] if "tips over" in w]
    said = float(warning.partition("tips over at ")[2].partition(" s")[0])
    with pytest.raises(DriveFault, match=r"tips over at .* s after .* % of the path: .*m/s2 are more than its wheels"):
        run_cell(tall, tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["outcome"] == "failed"
    assert summary["simulated_time_s"] == pytest.approx(said, abs=0.1)


def test_a_centre_of_mass_is_used_or_refused(tmp_path: Path) -> None:
    assert run_cell(cell(tmp_path, com='com = ["5mm", "-3mm"]'), tmp_path / "a").data["outcome"] == "done"
    with pytest.raises(CellError, match=r"com: \(90, 0\) mm came; the base tips over at rest"):
        run_cell(cell(tmp_path, com='com = ["90mm", "0mm"]'), tmp_path / "b")


def test_three_wheels_report_no_slip(tmp_path: Path) -> None:
    """Nothing contradicts them: no alarm, whatever slips, and the report says that it cannot be found."""
    with contextlib.suppress(DriveFault):  # it may well miss its path
        run_cell(cell(tmp_path, wheels=THREE, friction=0.12, sliding=0.08), tmp_path / "out")
    recording = read_recording(tmp_path / "out" / "recording.mcap")
    assert not [event for event in recording.events if event.source == "slip detection"]
    slips = json.loads((tmp_path / "out" / "summary.json").read_text())["slips"]
    assert slips
    assert not any(slip["detectable"] or slip["detected"] is not None for slip in slips)


@pytest.mark.parametrize("name", ["mecanum", "omni3_nofault", "all_ice"])
def test_cells_that_once_got_a_wrong_verdict(data_folder: Path, tmp_path: Path, name: str) -> None:
    path = data_folder / "faults" / "cells" / f"{name}.toml"
    if name == "all_ice":
        with pytest.raises(DriveFault, match="the path was not kept"):
            run_cell(path, tmp_path / "out")
        return
    answer = run_cell(path, tmp_path / "out")
    assert (answer.data["outcome"], answer.data["false_alarms"]) == ("done", [])


def test_mecanum_wheels_that_push_too_hard_are_warned_of(data_folder: Path) -> None:
    cells = data_folder / "faults" / "cells"
    assert any("more force than the floor takes" in w for w in check_cell(cells / "mec_hard.toml").data["warnings"])
    assert check_cell(cells / "mecanum.toml").data["warnings"] == []


def test_velocities_that_wheels_cannot_follow_are_named(tmp_path: Path) -> None:
    """A car may not go sideways, nor turn tighter than its steering lets it: by hand 0.3 m cot 30 deg + 0.1 m."""
    path = tmp_path / "cell.toml"
    path.write_text(
        '[cell]\nname = "car"\ntime_limit = "9s"\n[[robot]]\nname = "car"\nmodel = { arrangement = "ackermann", '
        'wheelbase = "300mm", track = "200mm", wheel_radius = "30mm", max_steering = "30deg", mass = "6kg" }\n'
        'velocity = [{ at = "0s", vx = "0.5m/s", vy = "0.3m/s" }, { at = "1s", vx = "0.5m/s", w = "30deg/s" }, '
        '{ at = "2s" }]\n',
        encoding="utf-8",
    )
    warnings = check_cell(path).data["warnings"]
    assert warnings == ["velocity at 0 s: its wheels cannot follow (0.5, 0.3, 0); the nearest is (0.5, 0, 0)"]


def driven(folder: Path, task: str, **changes: object) -> Path:
    """The cell with another task instead of its path."""
    path = cell(folder, **changes)
    head, _, rest = path.read_text(encoding="utf-8").partition("[path]")
    tail = rest.partition("[[faults]]")[1:]
    text = head.replace("[floor]", f"{task}\n[floor]") + "".join(tail)
    path.write_text(text, encoding="utf-8")
    return path


ARC = 'velocity = [{ at = "0s", vx = "1m/s", w = "1rad/s" }, { at = "3s" }]'


def test_velocities_are_judged_by_the_motion_that_was_commanded(tmp_path: Path) -> None:
    """The arc by the true pose: on a floor that grips it comes out, on ice it does not."""
    task = ARC
    assert run_cell(driven(tmp_path, task), tmp_path / "a").data["outcome"] == "done"
    true = read_recording(tmp_path / "a" / "recording.mcap").true_base
    turn = float(true.pose[-1, 2])
    assert turn == pytest.approx(3.0, abs=np.radians(10.0))  # rad, 1 rad/s for 3 s
    assert np.hypot(*true.pose[-1, :2]) == pytest.approx(2.0 * np.sin(1.5), abs=0.1)  # its chord, by hand
    with pytest.raises(DriveFault, match=r"the velocities were not driven: .* m off at .*, 0.099\d* m are allowed"):
        run_cell(driven(tmp_path, task, friction=0.01, sliding=0.005), tmp_path / "b")
    assert json.loads((tmp_path / "b" / "summary.json").read_text())["outcome"] == "failed"


def test_a_base_that_holds_stays_where_it_was(tmp_path: Path) -> None:
    assert run_cell(driven(tmp_path, 'hold = "1s"'), tmp_path / "a").data["outcome"] == "done"


def test_a_base_that_is_displaced_while_it_holds_has_failed(tmp_path: Path) -> None:
    """The judge itself: true poses that walk away from where it stood."""
    job = built(driven(tmp_path, 'hold = "1s"')).bases[0]
    judge, log = PathJudge(job), make_base(job, Floor(), np.random.default_rng(0)).buffer(500)
    log.body["x"] = np.linspace(0.0, 0.05, 500)
    judge.see(0, log)
    assert judge.verdict() == "its place was not kept: 0.05 m off at 0.50 s, 0.01 m are allowed"


def test_small_paths_may_be_missed_by_a_centimetre(tmp_path: Path) -> None:
    small = cell(tmp_path, speed=0.1)
    small.write_text(small.read_text().replace('size = "1m"', 'size = "20mm"'), encoding="utf-8")
    assert built(small).bases[0].task.tolerance.position == 0.01


def test_what_was_given_up_is_not_driven(tmp_path: Path) -> None:
    """With the heading kept and the path let go, `path_driven` is the part on which both were within."""
    chosen = cell(tmp_path, wheels=THREE, faults=DEAD, speed=0.4, path='keep = "heading"')
    answer = run_cell(chosen, tmp_path / "out")
    recording = read_recording(tmp_path / "out" / "recording.mcap")
    true, wanted = recording.true_base.pose, recording.base_reference.pose
    n = min(len(true), len(wanted))
    far = np.hypot(*(true[:n, :2] - wanted[:n, :2]).T)
    turn = np.abs(true[:n, 2] - wanted[:n, 2])
    steps = np.hypot(*np.diff(wanted[:n, :2], axis=0).T)
    within = ((far <= 0.05) & (turn <= np.radians(10.0)))[1:]
    assert answer.data["path_driven"] == pytest.approx(steps[within].sum() / steps.sum(), abs=0.05)
    assert answer.data["path_driven"] < 0.9


def test_check_says_when_the_motors_left_cannot_hold_the_choice(tmp_path: Path) -> None:
    """Two wheels of three at 2 m/s round a circle of 0.5 m: 8 m/s2 are more than the floor gives them."""
    fast = cell(tmp_path, wheels=THREE, faults=DEAD, speed=2.0, path='keep = "path"')
    fast.write_text(fast.read_text().replace('acceleration = "1.2m/s2"', 'acceleration = "8m/s2"'), encoding="utf-8")
    warnings = check_cell(fast).data["warnings"]
    assert any("without the motor of b, from 1 s on, the others cannot hold the path as fast" in w for w in warnings)
    slow = cell(tmp_path, wheels=THREE, faults=DEAD, speed=0.4, path='keep = "path"')
    assert not [w for w in check_cell(slow).data["warnings"] if "cannot hold" in w]
