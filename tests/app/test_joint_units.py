"""Units follow the joint's kind: degrees of joints that turn, mm of joints that slide, wherever values are written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from holonom import load_arm
from holonom.app.cell.check import check_cell
from holonom.app.console.cli import main
from holonom.app.recording import read_recording
from holonom.errors import InputError, OutOfLimits
from holonom.mechanics.motion import plan_joint

CELL = """
[cell]
name = "slides"
time_limit = "60s"

[[robot]]
model = "{}"
drives = "ideal"
home = {}
program = "p.arps"
"""
ARMS = {
    "scara": '["0deg", "0deg", "50mm", "0deg"]',
    "stanford": '["0deg", "90deg", "0.5m", "0deg", "30deg", "0deg"]',
}
STANFORD = (
    ".PROGRAM main()\nMOVE #there\nDRIVE 3, -50, 50\nMOVE #PPOINT(0, 90, 600, 0, 30, 0)\nHERE #p\nMOVE #p\n.END\n"
)
SCARA = ".PROGRAM main()\nMOVE #there\nDRIVE 3, -50, 50\nMOVE #PPOINT(0, 0, 180, 90)\nHERE #p\nMOVE #p\n.END\n"
PROGRAMS = {"stanford": (STANFORD, "10, 90, 400, 0, 20, 0"), "scara": (SCARA, "10, 20, 120, 30")}
VISITED = {"stanford": [0.5, 0.4, 0.35, 0.6], "scara": [0.05, 0.12, 0.07, 0.18]}


def cell(folder: Path, arm: str, home: str | None = None, there: str | None = None) -> Path:
    program, taught = PROGRAMS[arm]
    (folder / "p.arps").write_text(program, "utf-8")
    (folder / "p.loc").write_text(f"#there = {there or taught}\n", "utf-8")
    path = folder / "cell.toml"
    path.write_text(CELL.format(arm, home or ARMS[arm]), "utf-8")
    return path


@pytest.mark.parametrize("arm", ARMS)
def test_a_slide_goes_where_mm_say(tmp_path: Path, arm: str) -> None:
    path = cell(tmp_path, arm)
    assert check_cell(path).data["motions"] == 4
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    q = read_recording(tmp_path / "out" / "recording.mcap").joints.position[:, 2]
    for place in VISITED[arm]:
        assert np.abs(q - place).min() < 2e-3, "a blended motion flies by within 2 mm"
    assert q[0] == pytest.approx(VISITED[arm][0])
    assert q[-1] == pytest.approx(VISITED[arm][-1], abs=2e-4)


@pytest.mark.parametrize(
    ("arm", "home", "message"),
    [
        ("scara", '["0deg", "0deg", "50deg", "0deg"]', "a quantity of length is expected"),
        ("scara", '["0m", "0deg", "50mm", "0deg"]', "a quantity of angle is expected"),
        (
            "stanford",
            '["0deg", "90deg", "5m", "0deg", "30deg", "0deg"]',
            "5m came for joint3; 0.3048m to 1.27m is allowed",
        ),
        ("scara", '["45rad", "30rad", "50mm", "0deg"]', "are these degrees"),
    ],
)
def test_a_home_of_another_kind_is_refused(tmp_path: Path, arm: str, home: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        check_cell(cell(tmp_path, arm, home))


def test_a_taught_slide_is_named_in_mm(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"p.loc:1: taught location '#there': 400 mm came for quill; 0 to 210 mm"):
        check_cell(cell(tmp_path, "scara", there="0, 0, 400, 0"))


def test_degrees_for_radians_are_asked_about() -> None:
    arm = load_arm("puma560")
    with pytest.raises(OutOfLimits, match=r"shoulder is to go to 45 rad \(2578.31 deg\); .* are these degrees\?"):
        plan_joint(np.zeros(6), [0.0, 45.0, -180.0, 0.0, -45.0, 0.0], arm.limits)
    with pytest.raises(OutOfLimits) as caught:
        plan_joint(np.zeros(6), [0.0, 4.0, 0.0, 0.0, 0.0, 0.0], arm.limits)
    assert "degrees?" not in str(caught.value)
