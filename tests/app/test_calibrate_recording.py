"""A simulated base whose wheels differ from its data sheet: its recording gives the true ones back."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from rig_runs import record

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.app.console.cli import main
from holonom.app.odometry_log import read_log
from holonom.app.recording import Recorder
from holonom.app.recording.robot import ROBOT, base_words
from holonom.app.rig import Simulated
from holonom.closed_loop import BaseLoop
from holonom.errors import LogError
from holonom.machine import BaseController, PathLimits, plan_path
from holonom.machine.base.paths import PATHS
from holonom.mobile import WheelBase, mecanum, omni
from holonom.sim import BasePlant, Floor

SOCCER = Path(__file__).resolve().parents[2] / "examples" / "03_soccer_robot" / "cell.toml"
JOB = build_job(load_cell(SOCCER), SOCCER)
PARTS = np.array([1.012, 0.991, 1.007, 0.985])
"""True radii over those of the data sheet."""


def job(nominal: WheelBase, heading: str):
    """One slow lap of an eight on a good floor."""
    path = plan_path(PATHS.make("figure_of_eight", {"size": 2.0}), PathLimits(1.0, 2.5), heading=heading)
    task = dataclasses.replace(JOB.bases[0].task, path=path)
    base = dataclasses.replace(JOB.bases[0], base=nominal, task=task, faults=(), pose=path.pose[0])
    return dataclasses.replace(JOB, bases=(base,), floor=Floor(JOB.floor.material))


def of_size(base: WheelBase, parts: np.ndarray) -> WheelBase:
    wheels = [
        dataclasses.replace(wheel, radius=wheel.radius * part) for wheel, part in zip(base.wheels, parts, strict=True)
    ]
    return WheelBase(
        wheels, name=base.name, radius=base.radius, alpha=base.alpha, mass=base.mass, com_height=base.com_height
    )


def recorded(folder: Path, nominal: WheelBase) -> list[str]:
    """Simulate the true base on two ways, so that it goes all ways; record it under the data sheet's numbers."""
    paths = []
    for heading in ("tangent", "fixed"):
        made = job(nominal, heading)
        base = made.bases[0]
        plant = BasePlant(of_size(nominal, PARTS), base.drive, made.floor, rng=np.random.default_rng(33))
        loop = BaseLoop(BaseController(nominal, base.drive, base.settings), plant)
        loop.place(base.pose)
        paths.append(str(folder / f"{heading}.mcap"))
        record(made, Path(paths[-1]), Simulated({}, {"": loop}))
    return paths


BODY = {"alpha": 0.5, "mass": 6.35, "com_height": 0.04}


@pytest.mark.parametrize("drive", ["omni4_any", "mecanum"])
def test_the_true_wheels_come_back(tmp_path: Path, drive: str, capsys: pytest.CaptureFixture[str]) -> None:
    nominal = JOB.bases[0].base if drive == "omni4_any" else mecanum(0.16, 0.14, 0.027, **BODY)
    assert main(["calibrate", "odometry", *recorded(tmp_path, nominal), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["drive"] == drive
    physical = found["physical"]
    names = [name for name in physical["calibrated"] if name.startswith("diameter")]
    got = np.array([physical["calibrated"][name] / physical["nominal"][name] for name in names])
    assert np.allclose(got, PARTS, atol=2e-3), got
    before, after = found["errors_before"]["max_distance_m"], physical["errors_after"]["max_distance_m"]
    assert after < 0.2 * before


def test_the_words_of_a_recording_name_the_drive(tmp_path: Path) -> None:
    """What cannot be calibrated, and what was not recorded, is said."""
    two = omni([0.3, 2.0, 4.0], radius=0.1, wheel_radius=0.03)
    with Recorder(tmp_path / "a.mcap", two.driven, metadata=base_words(two, 4096, 3.0)):
        pass
    with pytest.raises(LogError, match="0 samples of encoder counts"):
        read_log([tmp_path / "a.mcap"])
    odd = {ROBOT: {"kind": "base", "description": "{}"}}
    with Recorder(tmp_path / "b.mcap", two.driven, metadata=odd):
        pass
    with pytest.raises(LogError, match="words on its robot cannot be read"):
        read_log([tmp_path / "b.mcap"])
    with Recorder(tmp_path / "c.mcap", two.driven):
        pass
    with pytest.raises(LogError, match="is no log"):
        read_log([tmp_path / "c.mcap"])
    skewed = json.loads(base_words(two, 4096, 3.0)[ROBOT]["description"])
    skewed["rows"][0] = [2.0, 0.0, 0.1]
    del skewed["base"]  # as recorded before wheels were
    with Recorder(tmp_path / "d.mcap", metadata={ROBOT: {"kind": "base", "description": json.dumps(skewed)}}):
        pass
    with pytest.raises(LogError, match="none of the drives that are known by their rows"):
        read_log([tmp_path / "d.mcap"])
