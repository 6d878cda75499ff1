"""A recording of `holonom run` of every arrangement gives its wheels back within three of its own deviations."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import root
from test_every_base import WHEELS

from holonom.app.calibrate.odometry import calibrate_odometry
from holonom.app.console.cli import main
from holonom.app.odometry_log import read_log
from holonom.app.recording import Recorder, read_recording
from holonom.app.recording.robot import ROBOT, base_words
from holonom.errors import LogError, ShapeError
from holonom.mobile import omni
from holonom.mobile.calibration import Run, calibrate

SIZE = {"ackermann": "8m", "dual_ackermann": "6m", "rocker6": "6m"}
TANGENT = ("omni", "mecanum", "swerve")
ROLLING = [arrangement for arrangement in WHEELS if arrangement not in ("segway", "skid_steer")]


def run(folder: Path, arrangement: str, more: str = "") -> Path:
    """An eight, so that it turns both ways; its recording."""
    heading = 'heading = "tangent"\n' if arrangement in TANGENT else ""
    (folder / "cell.toml").write_text(
        f'[cell]\nname = "{arrangement}"\nseed = 1\ntime_limit = "60s"\n'
        f'[base]\narrangement = "{arrangement}"\n{WHEELS[arrangement]}\n'
        f'mass = "8kg"\n[path]\nshape = "figure_of_eight"\nsize = "{SIZE.get(arrangement, "4m")}"\n'
        f'speed = "0.8m/s"\nacceleration = "0.8m/s2"\nposition_tolerance = "200mm"\nheading_tolerance = "20deg"\n'
        f"{heading}{more}",
        "utf-8",
    )
    assert main(["run", str(folder / "cell.toml"), "-o", str(folder / "out"), "--quiet"]) == 0
    return folder / "out" / "recording.mcap"


@pytest.mark.parametrize("arrangement", ROLLING)
def test_the_wheels_of_a_recording_come_back(arrangement: str, tmp_path: Path) -> None:
    """By the runs alone: the data sheet, which is right here, must not help."""
    data = calibrate_odometry([run(tmp_path, arrangement)], parameters="physical", data_sheet=False).data
    assert len(data["nominal"]) > 0
    for name, value in data["nominal"].items():
        away, deviation = data["calibrated"][name] - value, data["deviations"][name]
        assert abs(away) < 3.0 * deviation, f"{name}: {away:.3g} is {abs(away) / deviation:.1f} deviations"
        if name.startswith(("radius", "diameter", "track", "wheelbase")):
            assert deviation < 0.03 * value, name


def test_creep_would_be_taken_for_geometry(tmp_path: Path) -> None:
    """A base with its mass behind the axle seems narrower, by what its wheels creep; known creep is taken off."""
    log = read_log([run(tmp_path, "differential")])
    (with_,) = log.runs
    without = Run(with_.name, with_.time, with_.turns + with_.creep, with_.truth, with_.steering)
    nominal = {"wheelbase": 0.3, "diameter_left": 0.1, "diameter_right": 0.1}
    track, known = (calibrate([one], "differential", nominal, data_sheet=False) for one in (without, with_))
    assert track.values[0] < 0.999 * 0.3
    assert abs(track.values[0] - 0.3) > 10.0 * track.deviations[0], "which no noise explains"
    assert abs(known.values[0] - 0.3) < 0.2 * abs(track.values[0] - 0.3)
    assert known.deviations[0] == pytest.approx(with_.creep_share * abs(track.values[0] - known.values[0]), rel=0.5)


def balance(rims: np.ndarray, place: np.ndarray, acceleration: np.ndarray, turn: float) -> np.ndarray:
    """Twist (3,) at which four wheels (N m by magic formula, quarter of the weight each) give an acceleration (2,)."""
    peak, sliding, at = 0.8, 0.65, 0.05
    C = 2.0 - 2.0 / np.pi * np.arcsin(sliding / peak)
    B = np.tan(np.pi / (2.0 * C)) / at

    def missing(xi: np.ndarray) -> np.ndarray:
        slip = np.stack([rims - xi[0] + xi[2] * place[:, 1], -xi[1] - xi[2] * place[:, 0]], axis=1)
        size = np.hypot(*slip.T) + 1e-9
        force = (peak * np.sin(C * np.arctan(B * size)) * 9.81 / 4.0 / size)[:, None] * slip
        return np.array(
            [*(force.sum(axis=0) - acceleration), (place[:, 0] * force[:, 1] - place[:, 1] * force[:, 0]).sum()]
        )

    return root(missing, [rims.mean(), 0.0, turn], tol=1e-10).x


def test_the_effective_track_is_what_friction_makes_of_it(tmp_path: Path) -> None:
    """A skid steer has no true one: beside the balance of forces of its wheels, written here, and its true motion."""
    file = run(tmp_path, "skid_steer", 'law = "pure_pursuit"\n')
    data = calibrate_odometry([file], parameters="physical", data_sheet=False).data
    found, tracks = data["calibrated"], read_recording(file)
    twist, rims = tracks.true_base.twist, 0.05 * tracks.tracks["/truth/joint_states"].fields["velocity"]
    apart = rims[:, [1, 3]].mean(axis=1) - rims[:, [0, 2]].mean(axis=1)
    turning = np.abs(twist[:, 2]) > 0.2
    seen = float(apart[turning] @ twist[turning, 2] / (twist[turning, 2] @ twist[turning, 2]))
    assert found["effective_track"] == pytest.approx(seen, rel=0.03)
    place = np.array([(0.1, 0.2), (0.1, -0.2), (-0.1, 0.2), (-0.1, -0.2)])
    told = []
    for k in np.flatnonzero(turning)[::60]:
        vx, vy, w = twist[k]
        xi = balance(rims[k], place, np.array([-w * vy, w * vx]), w)
        told.append((apart[k] / xi[2], -xi[1] / xi[2]))
    track, centre = np.median(told, axis=0)
    assert found["effective_track"] == pytest.approx(track, rel=0.05)
    assert found["centre"] == pytest.approx(centre, abs=0.05 * 0.4)
    assert np.allclose([found[f"radius_{n}"] for n in ("front_left", "rear_right")], 0.05, rtol=0.01)


def test_what_a_recording_says_of_creep_may_not_contradict_its_wheels(tmp_path: Path) -> None:
    base = omni([0.3, 2.0, 4.0], radius=0.1, wheel_radius=0.03)
    words = base_words(base, 4096, 3.0)
    described = json.loads(words[ROBOT]["description"])
    described["creep"] = {"grip_per_ampere": [0.1], "full": [0.1, 0.1, 0.1], "across": 0.0}
    words[ROBOT]["description"] = json.dumps(described)
    with Recorder(tmp_path / "a.mcap", base.driven, metadata=words):
        pass
    with pytest.raises(LogError, match="words on its robot cannot be read"):
        read_log([tmp_path / "a.mcap"])
    rows = np.zeros((3, 2)), np.zeros((3, 3)), np.zeros((3, 0))
    with pytest.raises(ShapeError, match="drift of shape"):
        Run("a", np.arange(3.0), *rows, drift=np.zeros((2, 3)))
    with pytest.raises(ShapeError, match="creep of shape"):
        Run("a", np.arange(3.0), *rows, creep=np.zeros((3, 1)))
