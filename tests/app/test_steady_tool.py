"""An arm on a base keeps its tool where it is in the world while the base creeps under it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cell_files import write

from holonom.app.cell.check import check_cell
from holonom.app.recording import read_recording
from holonom.app.run import run_cell
from holonom.errors import CellError, MotionError
from holonom.machine.arm.steady import SteadyTool
from holonom.mechanics import load_arm
from holonom.spatial import pose

CELL = """[cell]
name = "steady"
time_limit = "10s"

[[robot]]
name = "agv"
arrangement = "mecanum"
wheelbase = "600mm"
track = "500mm"
wheel_radius = "80mm"
mass = "120kg"
velocity = [{ at = "0.2s", vx = "0.08m/s", w = "0.02rad/s" }, { at = "4.0s" }, { at = "4.2s" }]

[[robot]]
name = "arm"
model = "ur5e"
on = "agv.top"
drives = "ideal"
hold = "4.2s"
steady_tool = true
home = ["0deg", "-90deg", "100deg", "-100deg", "-90deg", "0deg"]

[[sensor]]
name = "gyro"
robot = "agv"
kind = "gyro"
bias = "0rad/s"

[[sensor]]
name = "accelerometer"
robot = "agv"
kind = "accelerometer"
bias = "0m/s2"
"""


def test_the_tool_stays_in_the_world(tmp_path: Path) -> None:
    """2 mm and 0.2 deg while the base creeps 0.3 m; its own dead reckoning is in it."""
    run_cell(write(tmp_path, CELL), tmp_path / "out")
    file = tmp_path / "out" / "recording.mcap"
    tool, base = read_recording(file, robot="arm").tool, read_recording(file, robot="agv").true_base
    assert np.hypot(*(base.pose[-1] - base.pose[0])[:2]) > 0.3
    assert np.linalg.norm(tool.position - tool.position[0], axis=1).max() < 2e-3
    turned = 2.0 * np.arccos(np.clip(np.abs(tool.quaternion @ tool.quaternion[0]), 0.0, 1.0))
    assert np.degrees(turned.max()) < 0.2


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('on = "agv.top"\n', ""), "only an arm that a base carries"),
        (('hold = "4.2s"\n', 'hold = "4.5s"\nlevels = { supervisor = "20ms" }\n'), "beside levels"),
    ],
)
def test_cells_in_which_it_cannot_be(change: tuple[str, str], message: str, tmp_path: Path) -> None:
    with pytest.raises(CellError, match=message):
        check_cell(write(tmp_path, CELL.replace(*change)))


def test_out_of_reach_ends_the_run_with_the_cause(tmp_path: Path) -> None:
    far = CELL.replace("0.08m/s", "0.8m/s")
    with pytest.raises(MotionError, match="the tool cannot stay where it is in the world"):
        run_cell(write(tmp_path, far), tmp_path / "out")


def test_a_base_at_even_speed_is_met_ahead() -> None:
    """Without noise the tool is where it was at every tick's end, while the base turns and drives."""
    arm = load_arm("ur5e")
    q = np.radians([0.0, -90.0, 100.0, -100.0, -90.0, 0.0])
    step, frame = (
        pose((1e-3, 2e-4, 0.0), [[np.cos(1e-3), -np.sin(1e-3), 0], [np.sin(1e-3), np.cos(1e-3), 0], [0, 0, 1]]),
        [np.eye(4)],
    )
    steady, held = SteadyTool(arm, lambda: frame[0], 0.01), arm.fk(q)
    steady.reference(q, 10)
    for k in range(50):
        frame[0] = frame[0] @ step
        reference = steady.reference(q, 10)
        assert reference.shape == (3, 10, 6)
        if k > 0:
            np.testing.assert_allclose(frame[0] @ arm.fk(reference[0, 0]), held, atol=1e-9)
