"""`holonom calibrate odometry` of any arrangement of wheels, from logs of the plain format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from base_runs import BASES, log_of

from holonom.app.calibrate.odometry import calibrate_odometry
from holonom.app.console.cli import main
from holonom.app.odometry_log import OdometryLog, read_log, write_log
from holonom.errors import LogError, OutputError, UnknownName
from holonom.mobile.calibration import Run, derived_parameters

GEOMETRY = {
    "ackermann": {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05},
    "swerve": {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05},
    "skid_steer": {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05},
    "omni": {"angles": [0.1, 1.3, 2.6, 3.8, 5.1], "radius": 0.2, "wheel_radius": 0.05},
    "differential": {"track": 0.3, "wheel_radius": 0.05},
}
NOISE = {"slip": 0.001, "place": 0.0005, "heading": 0.001, "ticks": 4096}


def written(
    kind: str, folder: Path, *, runs: str = "csv", bumped: tuple[str, ...] = ()
) -> tuple[Path, dict[str, float]]:
    parameters, rng = derived_parameters(BASES[kind]), np.random.default_rng(4)
    truth = parameters.nominal + 0.02 * parameters.scale * rng.uniform(-1.0, 1.0, len(parameters.names))
    numbers = dict(zip(parameters.names, truth.tolist(), strict=True))
    made = tuple(log_of(BASES[kind], numbers, rng, name=f"run-{k}", **NOISE) for k in range(2))
    log = OdometryLog(folder, kind, GEOMETRY[kind], None, made, bumped=bumped)
    return write_log(log, folder / "log", runs=runs), numbers


@pytest.mark.parametrize("kind", GEOMETRY)
def test_an_arrangement_is_calibrated_from_its_log(kind: str, tmp_path: Path) -> None:
    path, numbers = written(kind, tmp_path)
    data = calibrate_odometry([path], parameters="physical", rule="exact", output=tmp_path / "out").data
    assert (data["drive"], data["set"]) == (kind, "physical")
    assert set(data["calibrated"]) == set(numbers)
    for name, value in numbers.items():
        assert abs(data["calibrated"][name] - value) < 3.5 * data["deviations"][name], name
    assert data["errors_after"]["max_distance_m"] < data["errors_before"]["max_distance_m"]
    assert ("matrix" in data) == (kind not in ("ackermann", "swerve"))
    assert data["identifiability"]["never_told"] == {}
    assert data["nonsystematic"]["spread_m"] is None  # two runs of different courses
    assert (tmp_path / "out" / "odometry.png").exists()


def test_recordings_of_a_car_come_back(tmp_path: Path) -> None:
    path, _ = written("ackermann", tmp_path, runs="mcap")
    log = read_log([path])
    assert log.subject.columns.steering == ("front_left_steering", "front_right_steering")
    assert log.runs[0].steering.shape[1] == 2
    first = calibrate_odometry([path], parameters="physical", output=tmp_path / "out", mcap=True)
    again = calibrate_odometry([tmp_path / "out" / "log.toml"], parameters="physical")
    assert again.data["calibrated"] == pytest.approx(first.data["calibrated"], abs=1e-6)


def test_what_a_log_of_an_arrangement_may_not_say(tmp_path: Path) -> None:
    path, _ = written("ackermann", tmp_path)
    text = path.read_text(encoding="utf-8")
    for old, new, match in (
        ("wheelbase = 0.4", "wheelbase = -0.4", r"log.toml:4: geometry: .*wheelbase"),
        ("wheel_radius = 0.05", "wheelradius = 0.05", r"log.toml:4: geometry: .*wheel_radius"),
        ('"001-run-0.csv"', '"other.csv"', r"other.csv: cannot be read"),
        ("[geometry]", 'bumped = ["x.csv"]\n[geometry]', r"bumped: x.csv came, which is not among the runs"),
    ):
        path.write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(LogError, match=match):
            calibrate_odometry([path])
    with pytest.raises(UnknownName, match="did you mean 'ackermann'"):
        calibrate_odometry([path], drive="ackerman")


def test_steering_that_counts_the_other_way_is_named(tmp_path: Path) -> None:
    made = log_of(BASES["ackermann"], {}, np.random.default_rng(1), name="run")
    wrong = Run("run", made.time, made.turns, made.truth, -made.steering)
    path = write_log(OdometryLog(tmp_path, "ackermann", GEOMETRY["ackermann"], None, (wrong,)), tmp_path / "log")
    with pytest.raises(LogError, match="all steering columns count the other way"):
        read_log([path])


def test_bumped_runs_are_named_in_the_log(tmp_path: Path) -> None:
    path, _ = written("differential", tmp_path, bumped=("run-1",))
    assert read_log([path]).bumped == ("002-run-1",)


def test_a_gyro_and_an_optical_sensor_beside_the_wheels(tmp_path: Path) -> None:
    """Their numbers come back from columns `gyro`, `flow_x`, `flow_y`."""
    path, _ = written("differential", tmp_path)
    rng = np.random.default_rng(3)
    for file in sorted((tmp_path / "log").glob("*.csv")):
        names = file.read_text(encoding="utf-8").split("\n", 1)[0].split(",")
        rows = np.loadtxt(file, delimiter=",", skiprows=1)
        x, y, theta = (rows[:, names.index(name)] for name in ("x", "y", "theta"))
        dt, turn = np.diff(rows[:, 0], prepend=-0.05), np.diff(theta, prepend=theta[0])
        rate = 1.02 * turn / dt + 0.01 + 0.01 * rng.normal(size=len(dt))
        z = np.diff(x + 1j * y, prepend=x[0] + 1j * y[0]) * np.exp(-1j * (theta - 0.5 * turn))
        seen = (z + 1j * turn * (0.08 - 0.02j)) * np.exp(-0.3j) / 2.5e-5
        table = np.column_stack([rows, rate, np.round(seen.real), np.round(seen.imag)])
        header = ",".join([*names, "gyro", "flow_x", "flow_y"])
        np.savetxt(file, table, fmt="%.17g", delimiter=",", header=header, comments="")
    answer = calibrate_odometry([path], parameters="physical", rule="exact")
    gyro, optical = answer.data["gyro"], answer.data["optical"]
    assert abs(gyro["scale"]["value"] - 1.02) < 4.0 * gyro["scale"]["sigma"] < 0.05
    assert abs(gyro["bias"]["value"] - 0.01) < 4.0 * gyro["bias"]["sigma"] < 0.02
    assert optical["scale_m"] == pytest.approx(2.5e-5, rel=1e-3)
    assert (optical["x_m"], optical["y_m"]) == pytest.approx((0.08, -0.02), abs=1e-3)
    assert optical["angle_deg"] == pytest.approx(np.degrees(0.3), abs=0.1)
    assert "gyro: scale 1.0" in answer.text
    assert "optical sensor: at (0.08" in answer.text
    for old, new, match in (("flow_y", "other", "one of flow_x and flow_y"),):
        first = min((tmp_path / "log").glob("*.csv"))
        first.write_text(first.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
        with pytest.raises(LogError, match=match):
            calibrate_odometry([path])


def test_wheels_that_contradict_each_other_are_noted_as_slip(tmp_path: Path) -> None:
    """One of four Swedish wheels turns too far for half a second: no truth is needed to see it."""
    base = BASES["mecanum"]
    numbers = dict(zip(derived_parameters(base).names, derived_parameters(base).nominal.tolist(), strict=True))
    runs = []
    for k in range(2):
        run = log_of(base, numbers, np.random.default_rng(k), name=f"run-{k}", slip=0.001, place=0.0005, heading=0.001)
        turns = run.turns.copy()
        turns[100:110, 2] += 0.2 * k
        runs.append(Run(run.name, run.time, turns, run.truth, run.steering))
    geometry = {"wheelbase": 0.4, "track": 0.3, "wheel_radius": 0.05}
    path = write_log(OdometryLog(tmp_path, "mecanum", geometry, None, tuple(runs)), tmp_path / "log")
    notes = calibrate_odometry([path], parameters="physical", rule="exact").data["notes"]
    (told,) = [note for note in notes if "contradict" in note]
    assert told.startswith("run 002-run-1: from 5 to 5.45 s its wheels contradict each other by up to 0.0")


CELL = """[cell]
name = "base"
seed = 1
time_limit = "60s"
[base]
arrangement = "{}"
{}
mass = "8kg"
[path]
shape = "figure_of_eight"
size = "3m"
speed = "0.5m/s"
acceleration = "0.5m/s2"
{}
"""


@pytest.mark.parametrize(
    ("kind", "wheels", "heading", "near"),
    [
        ("swerve", 'wheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"', 'heading = "tangent"', 0.01),
        ("tricycle", 'wheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"', "", 0.01),
    ],
)
def test_a_recording_of_a_run_gives_the_wheels_back(
    kind: str, wheels: str, heading: str, near: float, tmp_path: Path
) -> None:
    """Its wheels are those of the cell, but for what they creep: within a percent."""
    (tmp_path / "cell.toml").write_text(CELL.format(kind, wheels, heading), encoding="utf-8")
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "run"), "--quiet"]) == 0
    data = calibrate_odometry([tmp_path / "run" / "recording.mcap"], parameters="physical").data
    assert data["drive"] == kind
    for name, value in data["nominal"].items():
        assert data["calibrated"][name] == pytest.approx(value, rel=near, abs=0.002), name
    with pytest.raises(OutputError, match="no log of the plain format names"):
        calibrate_odometry(
            [tmp_path / "run" / "recording.mcap"], parameters="physical", output=tmp_path / "o", mcap=True
        )
