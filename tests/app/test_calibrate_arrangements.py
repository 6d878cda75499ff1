"""`holonom calibrate odometry` of any arrangement of wheels, from logs of the plain format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from base_runs import BASES, log_of

from holonom.app.calibrate.odometry import calibrate_odometry
from holonom.app.odometry_log import OdometryLog, read_log, write_log
from holonom.errors import LogError, UnknownName
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
