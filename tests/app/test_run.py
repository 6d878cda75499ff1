"""`holonom run`: bad input ends with status 2 and writes nothing; what fails later leaves valid records, status 1."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from cells import CellCopy

from holonom import load_arm
from holonom.app.recording import Recording, read_recording


@pytest.fixture
def cell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> CellCopy:
    return CellCopy(tmp_path, capsys)


POINTS = r"(?s)points = \[.*?\n\]"


def points_on_a_line(count: int) -> str:
    rows = [f'{{ pixel = [{20 * k}, {10 * k}], table = ["{10 * k}mm", "{5 * k}mm"] }}' for k in range(count)]
    return f"points = [{', '.join(rows)}]"


# File, pattern, what to put in its place, what the message says.
BAD_INPUT = {
    "not TOML": ("cell.toml", r"\[cell\]", "[cell", r"cell.toml:\d+:\d+: not TOML"),
    "misspelt key": ("cell.toml", "opening =", "openning =", r"cell.toml:\d+: gripper.openning: .*mean 'opening'"),
    "unknown preset": ("cell.toml", "puma560", "puma650", r"cell.toml:\d+: arm.preset: no arm preset 'puma650'"),
    "unknown unit": ("cell.toml", "120mm", "120furlong", r"cell.toml:\d+: gripper.length: no unit of length 'furlong'"),
    "points on a line": ("cell.toml", POINTS, points_on_a_line(5), r"cell.toml:\d+: camera.points: .*line"),
    "too few points": ("cell.toml", POINTS, points_on_a_line(3), "camera.points: 3 came; at least 4"),
    "no photograph": ("cell.toml", "coins.png", "coin.png", r"cell.toml:\d+: camera.photograph: no file 'coin.png'"),
    "no image": ("cell.toml", "coins.png", "coins.csv", r"cell.toml:\d+: camera.photograph: .*coins.csv"),
    "home with NaN": ("cell.toml", '"-45deg"', '"nandeg"', r"cell.toml:\d+: arm.home\[4\]: 'nandeg' came"),
    "layout with NaN": ("coins.csv", r"\n\d[\d.]*", "\nnan", "coins.csv: part \\d+: u and v must be finite"),
    "unknown entry": ("cell.toml", r"\[program\]", '[program]\nentry = "sort"', "program.entry: .*no program 'sort'"),
    "syntax error": ("sort_coins.arps", r"\(1\) DO", "(1)", r"sort_coins.arps:\d+:\d+: .*expected"),
    "unknown name": ("sort_coins.arps", "APPRO coin", "APPRO coyn", r"sort_coins.arps:\d+:\d+: .*'coyn'.*never"),
    "no number taught": ("sort_coins.loc", "498", "nan", r"sort_coins.loc:\d+:\d+: 'nan' is no number"),
    "joints with NaN": ("sort_coins.loc", r"\Z", "#p = 0, nan, 0\n", r"sort_coins.loc:\d+:\d+: 'nan' is no number"),
    "taught out of reach": ("sort_coins.loc", "498", "1498", r"sort_coins.loc:\d+: .*'tray.small'.*out of reach"),
    "taught beyond a limit": (
        *("sort_coins.loc", "498,  48, 303, 0, 180", "450, 0, 500, 0, 0"),
        r"sort_coins.loc:\d+: .*'tray.small'.*outside a joint limit: \w+ would be at .* deg; its limits are",
    ),
    "joints beyond a limit": (
        *("sort_coins.loc", r"\Z", "#p[1] = 0, 0, 95, 0, 0, 0\n"),
        r"sort_coins.loc:\d+: .*'#p\[1\]': 95 deg came for elbow; -\d+ to \d+ deg is allowed",
    ),
    "joints too few": ("sort_coins.loc", r"\Z", "#p = 0, 5, 0\n", "'#p': 3 joint values came; the arm has 6"),
}


@pytest.mark.parametrize("case", BAD_INPUT)
@pytest.mark.parametrize("command", ["run", "check"])
def test_bad_input_is_told_and_nothing_written(case: str, command: str, cell: CellCopy) -> None:
    name, old, new, said = BAD_INPUT[case]
    cell.edit(name, old, new)
    status, text = cell.call(command)
    assert status == 2, text
    assert text.startswith("holonom: error: ")
    assert re.search(said, text), text
    assert not cell.out.exists()
    assert str(cell.folder / name) in text or name == "cell.toml"


def test_an_output_that_is_no_folder(cell: CellCopy) -> None:
    cell.out.write_text("mine", "utf-8")
    status, text = cell.call("run")
    assert status == 2
    assert "cannot write to the output folder" in text
    assert cell.out.read_text("utf-8") == "mine"


def test_errors_as_json(cell: CellCopy) -> None:
    cell.edit("sort_coins.loc", "498", "1498")
    status, text = cell.call("run", "--json")
    error = json.loads(text)["error"]
    assert (status, error["status"], error["type"]) == (2, 2, "ProgramError")
    assert error["message"].startswith(cell.line("sort_coins.loc", "1498"))


def records(cell: CellCopy, status: int, text: str, place: str) -> Recording:
    """The recording of a run that failed at a place: valid, with report and summary that say so."""
    assert status == 1, text
    assert f"holonom: error: {place}: " in text, text
    cause = text.partition("holonom: error: ")[2].splitlines()[0]
    assert f"what was recorded until then is in {cell.out}" in text
    assert sorted(path.name for path in cell.out.iterdir()) == ["recording.mcap", "report.html", "summary.json"]
    summary = json.loads((cell.out / "summary.json").read_text("utf-8"))
    assert summary["outcome"] == "failed"
    assert summary["failure"].startswith(cause)
    report = (cell.out / "report.html").read_text("utf-8")
    assert cause.split(": ")[-1].replace("'", "&#x27;") in report
    recording = read_recording(cell.out / "recording.mcap")
    (error,) = [event for event in recording.events if event.level == "error"]
    assert cause in error.text
    assert error.time == pytest.approx(summary["simulated_time_s"], abs=1.0)
    assert recording.end() == pytest.approx(summary["simulated_time_s"])
    return recording


def assert_stops(recording: Recording) -> None:
    """The arm is at rest at the end; its reference never brakes or speeds up harder than the joints may."""
    moved = np.diff(recording.true_joints.position[-3:], axis=0)  # a joint that sticks may slip a little at the last
    assert np.abs(moved[-1]).max() < 2e-4
    assert np.abs(recording.reference.velocity[-1]).max() < 1e-9
    limit = load_arm("puma560").limits.acceleration
    change = np.abs(np.diff(recording.reference.velocity, axis=0)).max(0) / 0.01
    assert (change <= 1.01 * limit).all(), change / limit


def test_a_coin_out_of_reach(cell: CellCopy) -> None:
    cell.edit("cell.toml", r'position = \["400mm"', 'position = ["640mm"')
    recording = records(cell, *cell.call("run"), cell.line("sort_coins.arps", "APPRO coin"))
    assert_stops(recording)
    assert "coin_24" in recording.frames


def test_a_motion_out_of_reach(cell: CellCopy) -> None:
    cell.edit("sort_coins.arps", "MOVES spot", "MOVES SHIFT(spot BY 500, 0, 0)")
    recording = records(cell, *cell.call("run"), cell.line("sort_coins.arps", "MOVES SHIFT"))
    assert_stops(recording)
    track = recording.frames["coin_01"]
    assert np.linalg.norm(track.position[-1] - track.position[0]) > 0.02, "the first coin was on its way"


def test_joints_beyond_their_limits(cell: CellCopy) -> None:
    cell.edit("sort_coins.arps", "APPRO coin, clear", "DRIVE 5, -150, 50")
    recording = records(cell, *cell.call("run"), cell.line("sort_coins.arps", "DRIVE 5"))
    assert_stops(recording)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("WHILE TRUE DO\n  pitch = 36\n  END", "a loop that neither moves nor waits"),
        ("pitch = 36 / 0", "division by zero"),
        ("WAIT SIG(9)", "not done after 2 s of simulated time"),
    ],
)
def test_a_program_that_fails_while_the_arm_moves(cell: CellCopy, wrong: str, said: str) -> None:
    cell.edit("cell.toml", '"300s"', '"2s"')
    cell.edit("sort_coins.arps", "APPRO coin, clear", f"APPRO coin, clear\n{wrong}")
    status, text = cell.call("run")
    assert said in text
    place = re.search(r"holonom: error: (.*?:\d+)", text)[1]
    assert place in {cell.line("sort_coins.arps", line) for line in wrong.splitlines()}
    assert_stops(records(cell, status, text, place))


def test_a_program_that_fails_at_once(cell: CellCopy) -> None:
    cell.edit("sort_coins.arps", "pitch = 36 ", "pitch = 36 / 0 ")
    records(cell, *cell.call("run"), cell.line("sort_coins.arps", "36 / 0"))


def test_a_finger_that_comes_down_on_a_coin(cell: CellCopy) -> None:
    cell.edit("sort_coins.arps", "MOVES coin", "MOVES SHIFT(coin BY 0, 14, 0)")
    status, text = cell.call("run")
    recording = records(cell, status, text, cell.line("sort_coins.arps", "MOVES SHIFT"))
    assert "a finger hit coin_01" in text
    assert_stops(recording)
    (hit,) = [event.time for event in recording.events if event.level == "error"]
    speed = np.linalg.norm(np.diff(recording.tool.position, axis=0), axis=1) / 0.01
    assert speed[np.searchsorted(recording.tool.time, hit) - 1] > 0.05, "it was moving when it hit the coin"
    assert recording.end() > hit


def test_a_drive_fault_names_the_axis_and_holds_the_arm(cell: CellCopy) -> None:
    cell.edit("cell.toml", '"3deg"', '"0.02deg"')
    status, text = cell.call("run")
    place = re.search(r"holonom: error: (.*sort_coins.arps:\d+): ", text)
    assert place, text
    recording = records(cell, status, text, place[1])
    assert re.search("waist|shoulder|elbow|wrist|flange", text), text
    moved = np.diff(recording.true_joints.position[-3:], axis=0)  # a joint that sticks may slip a little at the last
    assert np.abs(moved[-1]).max() < 2e-4


def test_another_seed_is_in_the_summary(cell: CellCopy) -> None:
    cell.edit("sort_coins.arps", "READY ", "HALT ")
    assert cell.call("run", "--seed", "7")[0] == 0
    assert json.loads((cell.out / "summary.json").read_text("utf-8"))["seed"] == 7
