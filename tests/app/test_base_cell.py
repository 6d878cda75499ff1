"""The cell file of a mobile base: what it says in SI, and one clear line for whatever is wrong with it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from holonom.app.cell import load_cell
from holonom.errors import CellError

SOCCER = Path(__file__).resolve().parents[2] / "examples" / "03_soccer_robot" / "cell.toml"
TEXT = SOCCER.read_text("utf-8")


def test_values_are_si() -> None:
    cell = load_cell(SOCCER)
    assert cell.robot[0].model.params.angles == pytest.approx(tuple(math.radians(a) for a in (57, 135, 225, 303)))
    assert cell.robot[0].drives.inductance == pytest.approx(0.56e-3)
    assert cell.robot[0].drives.rotor_inertia == pytest.approx(92.5e-7)
    assert cell.sensor[0].method.params.noise == pytest.approx(math.radians(0.12))
    assert cell.robot[0].controllers.traction_control


def test_what_is_left_out_has_a_default(tmp_path: Path) -> None:
    text = re.sub(r"\[gyro\].*?\n\n|\[\[faults\]\].*", "", TEXT, flags=re.DOTALL)
    path = tmp_path / "cell.toml"
    path.write_text(text, "utf-8")
    cell = load_cell(path)
    assert cell.fault == ()
    assert cell.sensor[0].method.params.noise == 0.0
    assert cell.robot[0].controllers.slip_detection


@pytest.mark.parametrize(
    ("old", "new", "key", "says"),
    [
        ('wheel_radius = "27.11mm"', 'wheel_radius = "0mm"', "base.wheel_radius", "is 0.0; it must be"),
        ('radius = "78.9mm"\n', "", "base", "radius missing; it needs radius (distance"),
        ('arrangement = "omni"', 'arrangement = "omny"', "base.arrangement", "did you mean 'omni'"),
        ('arrangement = "omni"', 'arrangement = "mecanum"', "base.angles", "no parameter of arrangement"),
        ('mass = "6.35kg"', "mass = 6.35", "base.mass", "6.35 came"),
        ('supply = "14.8V"', 'supply = "14.8A"', "drive.supply", "V or mV"),
        ('sliding_friction = 0.65', "sliding_friction = 0.9", "floor", "sliding friction is the smaller"),
        ('size = ["300mm", "50mm"]\n', "", "floor.patches[0]", "needs radius or size"),
        ('wheel = "rear left"', 'wheel = "rear lefd"', "faults[0].wheel", "did you mean 'rear left'"),
        ('kind = "motor_dead"', 'kind = "motor_died"', "faults[0].kind", "did you mean 'motor_dead'"),
        ('laps = 2', "laps = 0", "path.laps", "0 came"),
        ('shape = "figure_of_eight"', 'shape = "eight"', "path.shape", "figure_of_eight"),
    ],
)  # fmt: skip
def test_each_fault_is_named(tmp_path: Path, old: str, new: str, key: str, says: str) -> None:
    assert TEXT.count(old) >= 1
    path = tmp_path / "cell.toml"
    path.write_text(TEXT.replace(old, new, 1), "utf-8")
    with pytest.raises(CellError) as caught:
        load_cell(path)
    line = next(text for text in str(caught.value).splitlines() if f" {key}: " in text)
    assert re.match(rf"{re.escape(str(path))}:\d+: ", line)
    assert says in line


def test_an_arm_and_a_base_are_two_cells(tmp_path: Path) -> None:
    path = tmp_path / "cell.toml"
    path.write_text(TEXT + '\n[arm]\npreset = "puma560"\n', "utf-8")
    with pytest.raises(CellError, match=r"tables \[arm\] and \[base\] came; a cell has one of them"):
        load_cell(path)
