"""Logs of odometry: formats come back as they went, and every fault is named with file, line and column."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from holonom.app.odometry_log import OdometryLog, read_log, write_log
from holonom.errors import InputError, LogError, OutputError
from holonom.mobile.calibration import Run, calibrate, drive_parameters
from holonom.mobile.odometry import integrate

TIME = 0.05 * np.arange(200)
TICKS = 2796.8  # per turn of the wheel: 43.7 times 64
DIFFERENTIAL = {"wheelbase": 0.2, "diameter_left": 0.084, "diameter_right": 0.084}
TRICYCLE = {"wheelbase": 0.15, "diameter": 0.065, "steering_offset": 0.0}


def differential() -> Run:
    """Left wheel slower, then faster: an S."""
    turns = np.stack([0.06 + 0.03 * np.sin(0.4 * TIME), 0.09 - 0.01 * np.sin(0.4 * TIME)], axis=1)
    turns[0] = 0.0
    p = drive_parameters("differential", DIFFERENTIAL)
    return Run("s", TIME, turns, integrate(turns @ p.matrix(p.nominal).T), np.empty((200, 0)))


def tricycle() -> Run:
    turns, steering = np.round(np.full((200, 1), 20.0)) * 2 * np.pi / 1600, 0.5 * np.sin(0.3 * TIME)[:, None]
    turns[0] = 0.0
    p = drive_parameters("tricycle", TRICYCLE)
    run = Run("t", TIME, turns, np.empty((0, 3)), steering)
    return Run("t", TIME, turns, integrate(run.features @ p.matrix(p.nominal).T), steering)


def optiodom(folder: Path, table: np.ndarray, name: str = "diff", *, runs: int = 1, packed: bool = False) -> Path:
    """A folder as the data set has it."""
    metadata = {
        "diff": "type,diff,\nngear,43.7,\nencRes,64,\nLi,0.2,\nDi,0.084,0.084\nThi,,\nN,{},\nL,0.75,\n",
        "tricyc": "type,tricyc,\nngear,1,\nencRes,1600,\nLi,0.15,\nDi,0.065,\nThi,0,\nN,{},\nL,,\n",
    }[name]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "1_metadata.csv").write_text(metadata.format(runs))
    lines = "".join(",".join(f"{x:.17g}" for x in row) + "\n" for row in table)
    if packed:
        (folder / "1_run-01.csv.gz").write_bytes(gzip.compress(lines.encode()))
    else:
        (folder / "1_run-01.csv").write_text(lines)
    return folder


def diff_table() -> np.ndarray:
    run = differential()
    return np.column_stack([run.time, run.truth, run.turns[:, ::-1] * TICKS / (2 * np.pi)])


def tricycle_table() -> np.ndarray:
    run = tricycle()
    return np.column_stack([run.time, run.truth, np.round(run.turns * 1600 / (2 * np.pi)), run.steering])


@pytest.mark.parametrize("kind", ["csv", "mcap"])
@pytest.mark.parametrize("make", [differential, tricycle])
def test_logs_come_back_as_they_went(tmp_path: Path, kind, make: Callable[[], Run]) -> None:
    run = make()
    drive, nominal = ("differential", DIFFERENTIAL) if make is differential else ("tricycle", TRICYCLE)
    blind = Run("blind", run.time, run.turns, np.empty((0, 3)), run.steering)
    log = OdometryLog(tmp_path, drive, nominal, 1.7, (run, blind))
    back = read_log([write_log(log, tmp_path / "log", runs=kind)])
    assert (back.drive, dict(back.nominal), back.side, back.notes) == (drive, nominal, 1.7, ())
    assert [r.name for r in back.runs] == ["001-s" if make is differential else "001-t", "002-blind"]
    for ours, theirs in zip((run, blind), back.runs, strict=True):
        assert np.allclose(ours.time, theirs.time, atol=1e-9)
        assert np.allclose(ours.turns, theirs.turns, atol=1e-12)
        assert np.allclose(ours.steering, theirs.steering, atol=1e-15)
        assert ours.truth.shape == theirs.truth.shape
        assert np.allclose(ours.truth, theirs.truth, atol=1e-12)
    assert read_log([tmp_path / "log"]).drive == drive
    one = tmp_path / "log" / f"002-blind.{kind}"
    assert [r.name for r in read_log([one]).runs] == ["002-blind"]
    other = one.rename(one.with_stem("other"))
    with pytest.raises(LogError, match="does not name other"):
        read_log([other])


@pytest.mark.parametrize("packed", [False, True])
def test_a_folder_of_the_data_set(tmp_path: Path, packed: bool) -> None:
    folder = optiodom(tmp_path / "diff", diff_table(), packed=packed)
    log = read_log([folder])
    assert (log.drive, dict(log.nominal), log.side, log.notes) == ("differential", DIFFERENTIAL, 0.75, ())
    assert np.allclose(log.runs[0].turns, differential().turns)  # left, right, whatever the file's order
    one = folder / ("1_run-01.csv.gz" if packed else "1_run-01.csv")
    assert [r.name for r in read_log([one]).runs] == ["1_run-01"]
    assert read_log([folder / "1_metadata.csv"]).drive == "differential"


def test_missing_runs_are_noted(tmp_path: Path) -> None:
    log = read_log([optiodom(tmp_path, diff_table(), runs=4)])
    assert log.notes[0].startswith(f"{tmp_path}/1_metadata.csv:7: N names 4 runs, 1 are here")


def test_a_folder_above_several(tmp_path: Path) -> None:
    optiodom(tmp_path / "a", diff_table())
    optiodom(tmp_path / "b", tricycle_table(), "tricyc")
    with pytest.raises(LogError, match="differential, tricycle bases; name one of them with --drive"):
        read_log([tmp_path])
    assert [r.name for r in read_log([tmp_path], drive="tricycle").runs] == ["1_run-01"]
    broken = tmp_path / "a" / "1_run-01.csv"
    whole = broken.read_text()
    broken.write_text("of another drive, and not read")
    assert read_log([tmp_path], drive="tricycle").drive == "tricycle"
    broken.write_text(whole)
    with pytest.raises(LogError, match="none of an omni3 base"):
        read_log([tmp_path], drive="omni3")
    with pytest.raises(LogError, match="is of a tricycle base; a differential was asked for"):
        read_log([tmp_path / "b" / "1_metadata.csv"], drive="differential")
    with pytest.raises(LogError, match=r"run 1_run-01 of .*/a came before, as 1_run-01 of .*/a, and would count twice"):
        read_log([tmp_path / "a", tmp_path / "a" / "1_metadata.csv"])
    other = optiodom(tmp_path / "c", diff_table() + np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0]))
    (other / "1_metadata.csv").write_text((other / "1_metadata.csv").read_text().replace("Li,0.2,", "Li,0.205,"))
    both = read_log([tmp_path / "a", other])
    assert len(both.runs) == 2
    assert both.nominal["wheelbase"] == 0.2
    assert "states wheelbase 0.205" in both.notes[0]


def spoilt(change: Callable[[np.ndarray], object], table: Callable[[], np.ndarray] = diff_table) -> np.ndarray:
    values = table()
    replaced = change(values)
    return values if replaced is None else np.asarray(replaced)


def put(row: int | slice, column: int, value: float) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[row, column] = value

    return change


def times(column: slice | int, factor: float) -> Callable[[np.ndarray], None]:
    def change(values: np.ndarray) -> None:
        values[:, column] *= factor

    return change


FAULTS = [  # what was done to a good log, and what is said
    (put(9, 4, np.nan), r"1_run-01.csv:10: column 5 \(right\): nan came"),
    (put(20, 0, 0.3), r"1_run-01.csv:21: column 1 \(time\): 0.3 s after 0.95 s; time must grow"),
    (put(20, 0, 0.95), r"1_run-01.csv:21: column 1 \(time\): 0.95 s after 0.95 s"),
    (lambda v: np.delete(v, slice(50, 60), axis=0), r"1_run-01.csv:51: column 1 \(time\): 1 gap\(s\) up to 0.55 s"),
    (lambda v: np.delete(v, 7, axis=0), r"1_run-01.csv:8: column 1 \(time\): 1 gap\(s\) up to 0.1 s"),
    (lambda v: v[:, :5], r"1_run-01.csv:1: 5 columns; 6 are expected: time, x, y, theta, right, left"),
    (lambda v: v[:, [0, 1, 2, 3, 5, 4]], r"columns 6 \(left\), 5 \(right\) are swapped: read in the order right, left"),
    (times(slice(1, 3), 1000.0), r"_run-01.csv:1: by its wheels .* columns 2 \(x\), 3 \(y\) in mm instead of m"),
    (times(slice(1, 3), 0.001), r"by its wheels the base gets .* geometry or wheels in mm instead of m"),
    (times(3, 180 / np.pi), r"column 4 \(theta\) is in degrees instead of rad"),
    (times(slice(4, 6), 2 * np.pi / TICKS), r"moves and turns 0.00224\d times what the truth says: see diameters"),
    (times(slice(4, 6), TICKS), r"column \d \((left|right)\): the wheel's rim runs at .* m/s; up to 20 are plausible"),
    (lambda v: v[:1], r"1_run-01.csv:1: 1 sample; two or more"),
    (lambda v: v[:0], r"1_run-01.csv:1: 0 samples; two or more"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "match"), FAULTS, ids=[m[:28] for _, m in FAULTS])
def test_faults_are_named(tmp_path: Path, change, match: str) -> None:
    folder = optiodom(tmp_path, spoilt(change))
    with pytest.raises(LogError, match=match):
        read_log([folder])


def test_gaps_may_be_allowed(tmp_path: Path) -> None:
    folder = optiodom(tmp_path, np.delete(diff_table(), slice(50, 60), axis=0))
    log = read_log([folder], allow_gaps=True)
    assert "1 gap(s) up to 0.55 s, samples come every 0.05 s; allowed: cut there" in log.notes[0]
    assert [run.name for run in log.runs] == ["1_run-01 part 1", "1_run-01 part 2"]
    found = calibrate(log.runs, "differential", log.nominal)
    assert np.allclose(found.values, found.nominal, rtol=1e-6)  # what was driven in the gap is nobody's
    few = optiodom(tmp_path / "few", np.delete(diff_table(), slice(5, 20), axis=0))
    log = read_log([few], allow_gaps=True)
    assert ", 1 of under 16 samples left out" in log.notes[0]
    assert [run.name for run in log.runs] == ["1_run-01"]


def test_swapped_and_mistaken_columns_of_a_tricycle(tmp_path: Path) -> None:
    swapped = tricycle_table()[:, [0, 1, 2, 3, 5, 4]]
    with pytest.raises(LogError, match=r"column 6 \(steering\): .* columns front and steering are swapped"):
        read_log([optiodom(tmp_path / "a", swapped, "tricyc")])
    degrees = tricycle_table()
    degrees[:, 5] *= 180 / np.pi
    with pytest.raises(LogError, match="degrees instead of rad"):
        read_log([optiodom(tmp_path / "b", degrees, "tricyc")])
    mirrored = tricycle_table()
    mirrored[:, 5] *= -1.0
    with pytest.raises(LogError, match=r"column 6 \(steering\) counts the other way"):
        read_log([optiodom(tmp_path / "c", mirrored, "tricyc")])


METADATA = [
    ("type,diff", "type,car", r":1: type 'car' came; one of diff, tricyc, omni3, omni4"),
    ("type,diff,\n", "", r"type is missing or empty"),
    ("Di,0.084,0.084", "Di,0.084", r":5: Di: 1 number\(s\) came; a differential base has 2"),
    ("Di,0.084,0.084", "Di,0.084,0.084,0.084", r":5: Di: 3 number\(s\) came"),
    ("encRes,64", "encRes,0", r":3: encRes: 0 came; numbers above zero"),
    ("Li,0.2", "Li,wide", r":4: Li: wide came; numbers are expected"),
    ("Li,0.2", "Li,nan", r":4: Li: nan came; finite"),
    ("Li,0.2", "Li,", r":4: Li is missing or empty"),
    ("Di,0.084,0.084", "Di,84,84", r"rim runs at .* diameter is in m, not mm"),
    ("Li,0.2", "Li,200", r"turns 0.001 times what the truth says"),
]


@pytest.mark.parametrize(("old", "new", "match"), METADATA, ids=[f"{o} to {n}".strip() for o, n, _ in METADATA])
def test_faults_of_the_metadata(tmp_path: Path, old: str, new: str, match: str) -> None:
    folder = optiodom(tmp_path, diff_table())
    path = folder / "1_metadata.csv"
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(LogError, match=match):
        read_log([folder])


def test_text_and_ragged_rows(tmp_path: Path) -> None:
    path = optiodom(tmp_path, diff_table()) / "1_run-01.csv"
    lines = path.read_text().splitlines()
    for number, line, match in (
        (5, "0.2,0,0,0,1,fast", r"1_run-01.csv:5: column 6 \(left\): 'fast' is no number"),
        (7, "0.3,0,0,0,1", r"1_run-01.csv:7: 5 columns; 6 are expected"),
        (9, "\n0.4,0,0,0,1,x", r"1_run-01.csv:10: column 6"),  # an empty line before it
    ):
        path.write_text("\n".join([*lines[: number - 1], line, *lines[number:]]))
        with pytest.raises(LogError, match=match):
            read_log([tmp_path])
    path.write_bytes(b"\xff\xfe0,1\n")
    with pytest.raises(LogError, match="not UTF-8"):
        read_log([tmp_path])
    (tmp_path / "1_run-01.csv.gz").write_bytes(b"no gzip")
    with pytest.raises(LogError, match="run 1 is there twice"):
        read_log([tmp_path])
    path.unlink()
    with pytest.raises(LogError, match="cannot be read"):
        read_log([tmp_path])
    (tmp_path / "1_run-01.csv.gz").unlink()
    with pytest.raises(LogError, match="no run files"):
        read_log([tmp_path])


PLAIN = """drive = "differential"
runs = ["run.csv"]

[geometry]
wheelbase = 0.2
diameter_left = 0.084
diameter_right = 0.084

[encoder]
ticks = 64
gear = 43.7
bits = 16

[units]
wheels = "counts"
heading = "deg"
position = "mm"
"""


def plain(folder: Path, text: str = PLAIN, header: str = "time,x,left,right,y,theta") -> Path:
    """Running 16-bit counters, mm, degrees, columns in another order."""
    run = differential()
    counts = np.round(np.cumsum(run.turns, axis=0) * TICKS / (2 * np.pi) + 65000.0) % 65536
    truth = run.truth * [1000.0, 1000.0, 180 / np.pi]
    columns = {"time": run.time, "left": counts[:, 0], "right": counts[:, 1]}
    columns |= dict(zip(("x", "y", "theta"), truth.T, strict=True))
    rows = np.column_stack([columns.get(name, run.time) for name in header.split(",")])
    np.savetxt(folder / "run.csv", rows, delimiter=",", header=header, comments="")
    (folder / "log.toml").write_text(text)
    return folder / "log.toml"


def test_units_counters_and_order_of_columns(tmp_path: Path) -> None:
    back = read_log([plain(tmp_path)]).runs[0]
    assert np.allclose(np.cumsum(back.turns, axis=0), np.cumsum(differential().turns, axis=0), atol=2 * np.pi / TICKS)
    assert np.allclose(back.truth, differential().truth, atol=1e-9)


DESCRIPTIONS = [
    (
        '"differential"',
        '"diff"',
        r"log.toml:1: drive: no setting 'diff'; there is ackermann, bicycle, differential, "
        r"dual_ackermann, mecanum, omni, omni3, omni3_any",
    ),
    ('runs = ["run.csv"]', "runs = []", r"log.toml:2: runs: 0 came; at least 1 are needed: files of the runs"),
    ("run.csv", "other.csv", r"other.csv: cannot be read: No such file"),
    (
        "wheelbase = 0.2\n",
        "",
        r"log.toml:4: geometry: parameters diameter_left, diameter_right came; a differential has",
    ),
    ("wheelbase = 0.2", "wheelbase = -1.0", r"log.toml:4: geometry: wheelbase -1.0 came"),
    (
        "ticks = 64",
        "ticks = 0",
        r"log.toml:10: encoder.ticks: 0 came; it should be greater than 0: ticks per turn of the encoder's shaft",
    ),
    (
        "gear = 43.7",
        "gaer = 43.7",
        r"log.toml:11: encoder.gaer: no key 'gaer'; there is bits, gear, ticks; did you mean 'gear'\?",
    ),
    (
        "[encoder]\nticks = 64\ngear = 43.7\nbits = 16\n",
        "",
        r"log.toml:11: units.wheels: counts came and there is no table \[encoder\]",
    ),
    ('wheels = "counts"', "wheels = counts", r"log.toml:15:10: not TOML: Invalid value; .* lines such as drive = "),
    ('position = "mm"', 'position = "m"', r"columns 2 \(x\), 5 \(y\) in mm instead of m"),
]


@pytest.mark.parametrize(("old", "new", "match"), DESCRIPTIONS, ids=[n.strip() or o[:12] for o, n, _ in DESCRIPTIONS])
def test_faults_of_the_description(tmp_path: Path, old: str, new: str, match: str) -> None:
    with pytest.raises(LogError, match=match):
        read_log([plain(tmp_path, PLAIN.replace(old, new))])


@pytest.mark.parametrize(
    ("header", "match"),
    [
        ("time,x,left,y,theta", r"run.csv:1: no column right; there is time, x, left, y, theta"),
        ("time,left,right,x,y", r"run.csv:1: no column theta"),
        ("time,left,left,right", r"run.csv:1: column 3: there are two columns 'left'"),
        ("time,left,,right", r"run.csv:1: column 3: '' is no name"),
    ],
)
def test_faults_of_the_header(tmp_path: Path, header: str, match: str) -> None:
    with pytest.raises(LogError, match=match):
        read_log([plain(tmp_path, header=header)])


def test_paths_that_lead_nowhere(tmp_path: Path) -> None:
    for path, match in (
        (tmp_path / "absent", "absent is not there"),
        (tmp_path, "neither a file"),
        (tmp_path / "x.txt", "x.txt is no log"),
    ):
        (tmp_path / "x.txt").write_text("x")
        with pytest.raises(LogError, match=match):
            read_log([path])
    with pytest.raises(LogError, match="no log came"):
        read_log([])
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        write_log(OdometryLog(tmp_path, "differential", DIFFERENTIAL, None, ()), tmp_path / "file")
    assert issubclass(LogError, InputError)


def test_all_sets_that_are_here_read_without_a_fault(data_folder: Path) -> None:
    """No check refuses a log that is as it should be; missing runs are noted."""
    optiodom_folder = data_folder / "odometry" / "optiodom"
    for drive in ("differential", "tricycle", "omni3", "mecanum"):
        log = read_log([optiodom_folder], drive=drive)
        assert len(log.runs) >= 2
        assert any("N names" in note for note in log.notes) == (drive == "mecanum")
