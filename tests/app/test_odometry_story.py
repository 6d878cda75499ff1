"""Wheels and truth that do not go together: every swap, sign and unit is named on every drive; spells are noted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from holonom.app.odometry_log import OdometryLog, read_log, write_log
from holonom.app.odometry_log.story import _candidate, _Reading
from holonom.errors import LogError
from holonom.mobile.calibration import Run, drive_parameters, wheels_of
from holonom.mobile.odometry import integrate

NOMINAL = {
    "differential": {"wheelbase": 0.3, "diameter_left": 0.1, "diameter_right": 0.1},
    "tricycle": {"wheelbase": 0.4, "diameter": 0.1, "steering_offset": 0.0},
    "omni3": {"wheel_distance": 0.2, **{f"diameter_wheel_{k}": 0.1 for k in (1, 2, 3)}},
    "mecanum": {
        "wheelbase_plus_track": 0.5,
        **{f"diameter_{end}_{side}": 0.1 for end in ("front", "rear") for side in ("left", "right")},
    },
}
TIME = 0.02 * np.arange(600)
SIDEWAYS = {"differential": 0.0, "tricycle": 0.0, "omni3": 0.2, "mecanum": 0.2}


def drive(name: str, *, seed: int = 0) -> Run:
    """A winding run whose true numbers are up to 3 % off the nominal ones, with noise of the tracker."""
    rng = np.random.default_rng(seed)
    p = drive_parameters(name, NOMINAL[name])
    M = p.matrix(p.nominal + 0.03 * p.scale * rng.uniform(-1.0, 1.0, len(p.names)))
    twist = np.stack(
        [0.4 + 0.1 * np.sin(TIME), SIDEWAYS[name] * np.cos(0.5 * TIME), 0.8 * np.sin(0.7 * TIME) + 0.2], axis=1
    )
    twist[0] = 0.0
    features = 0.02 * twist @ np.linalg.pinv(M).T
    turns, steering = features, np.empty((len(TIME), 0))
    if name == "tricycle":
        turns = np.hypot(*features.T)[:, None]
        steering = np.arctan2(features[:, 1], features[:, 0])[:, None]
    truth = integrate(features @ M.T) + rng.normal(size=(len(TIME), 3)) * [5e-4, 5e-4, 1e-3]
    return Run("run", TIME, turns, truth, steering)


def read(
    folder: Path, name: str, change: Callable[[dict[str, np.ndarray]], object] = lambda columns: None
) -> list[str]:
    """Notes on a run whose columns were changed."""
    path = write_log(OdometryLog(folder, name, NOMINAL[name], None, (drive(name),)), folder / "log")
    file = folder / "log" / "001-run.csv"
    header, rows = file.read_text().splitlines()[0], np.loadtxt(file, delimiter=",", skiprows=1)
    columns = dict(zip(header.split(","), rows.T.copy(), strict=True))
    change(columns)
    np.savetxt(file, np.column_stack(list(columns.values())), delimiter=",", header=header, comments="", fmt="%.12g")
    return list(read_log([path]).notes)


def swap(a: str, b: str) -> Callable[[dict[str, np.ndarray]], None]:
    def change(columns: dict[str, np.ndarray]) -> None:
        columns[a], columns[b] = columns[b], columns[a]

    return change


def times(factor: float, *names: str) -> Callable[[dict[str, np.ndarray]], None]:
    def change(columns: dict[str, np.ndarray]) -> None:
        for name in names:
            columns[name] = factor * columns[name]

    return change


def wrapped_degrees(columns: dict[str, np.ndarray]) -> None:
    columns["theta"] = (np.degrees(columns["theta"]) + 180.0) % 360.0 - 180.0


TRUTH = [
    (swap("x", "y"), r"columns \d \(x\) and \d \(y\) are swapped"),
    (swap("x", "theta"), r"columns \d \(x\) and \d \(theta\) are swapped"),
    (swap("y", "theta"), r"columns \d \(y\) and \d \(theta\) are swapped"),
    (times(-1.0, "x"), r"column \d \(x\) counts the other way"),
    (times(-1.0, "y"), r"column \d \(y\) counts the other way"),
    (times(-1.0, "theta"), r"column \d \(theta\) counts the other way"),
    (times(-1.0, "x", "y"), r"column \d \(theta\) is not the heading from x, but \+180 degrees off"),
    (times(2.0, "x", "y"), r"gets 0.5\d* times as far as by the truth: the unit of columns \d \(x\), \d \(y\)"),
    (times(1e3, "x", "y"), r"columns \d \(x\), \d \(y\) in mm instead of m"),
    (times(1e2, "x", "y"), r"columns \d \(x\), \d \(y\) in cm instead of m"),
    (times(1 / 0.0254, "x", "y"), r"columns \d \(x\), \d \(y\) in inch instead of m"),
    (wrapped_degrees, r"column \d \(theta\) is in degrees instead of rad"),
]


@pytest.mark.parametrize("name", NOMINAL)
@pytest.mark.parametrize(("change", "match"), TRUTH, ids=[m[:40] for _, m in TRUTH])
def test_mistaken_truths_are_named(tmp_path: Path, name: str, change, match: str) -> None:
    with pytest.raises(LogError, match=rf"001-run.csv:2: .*{match}"):
        read(tmp_path, name, change)


@pytest.mark.parametrize("name", NOMINAL)
def test_good_logs_pass_without_a_note(tmp_path: Path, name: str) -> None:
    assert read(tmp_path, name) == []


@pytest.mark.parametrize("name", NOMINAL)
def test_wheels_that_count_the_other_way_or_are_swapped(tmp_path: Path, name: str) -> None:
    wheels, steered = wheels_of(name)
    for k, wheel in enumerate(wheels):
        with pytest.raises(LogError, match=rf"\({wheel}\) counts the other way"):
            read(tmp_path / f"a{k}", name, times(-1.0, wheel))
    for k, wheel in enumerate(wheels[1:]):
        with pytest.raises(LogError, match=rf"\({wheel}\).*are swapped: read in the order"):
            read(tmp_path / f"b{k}", name, swap(wheels[0], wheel))
    if steered:
        with pytest.raises(LogError, match=r"\(steering\) counts the other way"):
            read(tmp_path / "c", name, times(-1.0, "steering"))
    else:
        with pytest.raises(LogError, match="all count the other way"):
            read(tmp_path / "c", name, times(-1.0, *wheels))
    with pytest.raises(
        LogError, match=r"moves and turns (9|10)\.\d+ times what the truth says: see diameters, encoder, gear"
    ):
        read(tmp_path / "d", name, times(10.0, *wheels))


def test_two_mistakes_at_once(tmp_path: Path) -> None:
    def both(columns: dict[str, np.ndarray]) -> None:
        swap("x", "y")(columns)
        times(1e3, "x", "y")(columns)

    with pytest.raises(LogError, match=r"\(x\) and 5 \(y\) are swapped and .* in mm instead of m"):
        read(tmp_path, "differential", both)


def test_a_truth_of_another_run_is_refused(tmp_path: Path) -> None:
    def other(columns: dict[str, np.ndarray]) -> None:
        columns["x"], columns["y"], columns["theta"] = 0.3 * np.sin(TIME), 0.2 * np.cos(0.8 * TIME), -np.sin(3 * TIME)

    with pytest.raises(LogError, match=r"disagree by \d+% of the motion, and no swapped column"):
        read(tmp_path, "differential", other)


def test_time_in_milliseconds(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"column 1 \(time\): samples come every 20 s .* time in ms instead of s"):
        read(tmp_path, "differential", times(1e3, "time"))


def jump(columns: dict[str, np.ndarray]) -> None:
    columns["x"][300:] += 0.3


def slip(columns: dict[str, np.ndarray]) -> None:
    columns[next(iter(columns.keys() - {"time", "x", "y", "theta", "steering"}))][200:260] *= 3.0


def dropout(columns: dict[str, np.ndarray]) -> None:
    for name in columns.keys() - {"time", "x", "y", "theta", "steering"}:
        columns[name][200:260] = 0.0


@pytest.mark.parametrize("name", NOMINAL)
def test_jumps_slip_and_dropouts_are_noted(tmp_path: Path, name: str) -> None:
    """Where: the lines of the file (the header is the first), within half a window of what was done."""
    (note,) = read(tmp_path / "a", name, jump)
    assert note.startswith(f"{tmp_path}/a/log/001-run.csv:302: at 6 s the truth jumps by 0.")
    (note,) = read(tmp_path / "b", name, dropout)
    assert "count(s) nothing while the base moves" in note
    first, last = map(int, note.split(":")[1].split("-"))
    assert abs(first - 202) <= 13
    assert abs(last - 261) <= 13
    (note,) = read(tmp_path / "c", name, slip)
    assert "wheels" in note
    assert "disagree by up to" in note
    first, last = map(int, note.split(":")[1].split("-"))
    assert abs(first - 202) <= 13
    assert abs(last - 261) <= 13


def test_noise_of_a_turn_on_the_spot_is_no_unit(tmp_path: Path) -> None:
    """The truth wanders by millimetres while nothing is driven: a way that is no way."""
    rng = np.random.default_rng(2)
    turns = np.tile([-0.02, 0.02], (len(TIME), 1))
    turns[0] = 0.0
    p = drive_parameters("differential", NOMINAL["differential"])
    truth = integrate(turns @ p.matrix(p.nominal).T) + rng.normal(size=(len(TIME), 3)) * [3e-3, 3e-3, 0.0]
    run = Run("spin", TIME, turns, truth, np.empty((len(TIME), 0)))
    log = OdometryLog(tmp_path, "differential", NOMINAL["differential"], None, (run,))
    assert read_log([write_log(log, tmp_path)]).notes == ()


def test_runs_of_single_samples_are_cut_at_gaps(tmp_path: Path) -> None:
    run = drive("differential")
    kept = np.delete(np.arange(len(TIME)), slice(250, 300))
    holed = Run("run", run.time[kept], run.turns[kept], run.truth[kept], run.steering[kept])
    log = OdometryLog(tmp_path, "differential", NOMINAL["differential"], None, (holed,))
    back = read_log([write_log(log, tmp_path)], allow_gaps=True)
    assert [part.name for part in back.runs] == ["001-run part 1", "001-run part 2"]
    assert not back.runs[1].turns[0].any()
    assert "cut there" in back.notes[0]


@pytest.mark.parametrize("count", [2, 3])
def test_runs_of_a_few_samples_are_read_quietly(tmp_path: Path, count: int) -> None:
    run = drive("differential")
    short = Run("run", run.time[:count], run.turns[:count], run.truth[:count], run.steering[:count])
    log = OdometryLog(tmp_path, "differential", NOMINAL["differential"], None, (short,))
    assert len(read_log([write_log(log, tmp_path)]).runs[0].time) == count


OPTIODOM = ["diff/square/230620202042", "tricyc/square/140120211446", "omni3/circular/221220201730"]


@pytest.mark.parametrize("folder", OPTIODOM)
def test_swapped_truths_of_real_logs(data_folder: Path, tmp_path: Path, folder: str) -> None:
    source = data_folder / "odometry" / "optiodom" / folder
    metadata, file = next(source.glob("*_metadata.csv")), next(source.glob("*_run-01.csv"))
    (tmp_path / metadata.name).write_text(metadata.read_text())
    rows = np.loadtxt(file, delimiter=",")
    for column, match in ((2, "(x) and 3 (y) are swapped"), (3, "(x) and 4 (theta) are swapped")):
        changed = rows.copy()
        changed[:, [1, column]] = rows[:, [column, 1]]
        np.savetxt(tmp_path / file.name, changed, delimiter=",", fmt="%.12g")
        with pytest.raises(LogError) as error:
            read_log([tmp_path])
        assert match in str(error.value)


def test_turns_that_are_noise_are_in_no_other_unit() -> None:
    """Of wheels in an order in which they turn nothing: the truth's turn is missing, not 2,000 times too large."""
    ways, rng = 0.1 * np.ones(200), np.random.default_rng(2)
    truth = np.column_stack([ways, 0.0 * ways, 0.2 * ways])
    noise = np.column_stack([ways, 0.0 * ways, 1e-3 * ways * rng.normal(size=200)])
    degrees = truth * [1.0, 1.0, 180.0 / np.pi]
    lost, right = (_candidate(_Reading((), wheels, of)) for wheels, of in ((noise, truth), (truth, degrees)))
    assert lost.faults == ()
    assert lost.miss == pytest.approx(0.2 / 1.2, rel=0.01)
    assert right.miss < 1e-9
    assert "degrees" in right.faults[0]
