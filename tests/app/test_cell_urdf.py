"""A cell whose arm is a robot file with doubts: notes, or refused where the cell asks for a strict reading."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from holonom.app.cell import load_cell
from holonom.app.console.cli import main
from holonom.errors import CellError, InputError

BODY = '<inertial><mass value="3"/><inertia ixx="0.01" iyy="0.1" izz="{}" ixy="0" ixz="0" iyz="0"/></inertial>'
ARM = f"""<robot name="two">
<link name="base"/> <link name="upper">{BODY.format(0.5)}</link> <link name="fore">{BODY.format(0.1)}</link>
<link name="camera_link"/>
<joint name="i" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/></joint>
<joint name="j" type="revolute"><parent link="upper"/><child link="fore"/><axis xyz="0 0 1"/>
<origin xyz="0.4 0 0"/><limit lower="-1" upper="2" effort="9"/></joint>
<joint name="e" type="fixed"><parent link="fore"/><child link="camera_link"/><origin xyz="0.4 0 0"/></joint>
</robot>"""


def cell(folder: Path, options: str = "") -> Path:
    (folder / "arm.urdf").write_text(ARM)
    path = folder / "cell.toml"
    path.write_text(f'[cell]\nname = "c"\ntime_limit = "5s"\n[[robot]]\nmodel = {{ file = "arm.urdf"{options} }}\n')
    return path


def notes(path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["check", "--json", str(path)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    return "\n".join(json.loads(out)["notes"])


def test_check_shows_what_was_passed_over_and_guessed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = notes(cell(tmp_path), capsys)
    assert "line 6: <limit> of joint 'j' needs velocity=\"...\"; it is missing or empty: it has no such limit" in told
    assert "line 2: link 'upper' has an inertia that no body has" in told
    assert "line 2: no link is called like a tool: 'fore' is taken for the tool, a guess" in told
    assert "its drives are ideal: arm 'two' states no inertia" in told
    told = notes(cell(tmp_path, ', check_inertia = false, tip = "fore"'), capsys)
    assert "no body has" not in told
    assert "a guess" not in told


def test_a_cell_can_ask_for_a_strict_reading(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cell.toml:5: robot\[0\].model: .*line 6: <limit> of joint 'j' needs veloc"):
        load_cell(cell(tmp_path, ', check = "strict"'))
    with pytest.raises(CellError, match="no setting 'loose'; there is strict, warn"):
        load_cell(cell(tmp_path, ', check = "loose"'))
