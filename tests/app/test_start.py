"""`holonom demo` and `holonom new`: each arm and each base that can run has a first cell that runs at once."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

from holonom.app.cell import load_cell
from holonom.app.cell.check import check_cell
from holonom.app.console.cli import main
from holonom.app.start import demo, new
from holonom.app.start.arm import TURN, arm_starts, reach
from holonom.app.start.base import base_starts, runnable
from holonom.app.start.demo import DEFAULT, example, examples
from holonom.app.start.text import head
from holonom.errors import InputError, UnknownName
from holonom.mobile import ARRANGEMENTS
from holonom.model import PRESETS, JointLimits, load_model

FIRST = [("arm", name) for name in PRESETS] + [("base", name) for name in runnable()] + [("agv", "scara")]

URDF = """<robot name="own">
  <link name="base_link"/>
  <link name="upper"><inertial><mass value="2"/><origin xyz="0 0 0.1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" iyz="0" ixz="0"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base_link"/><child link="upper"/><origin xyz="0 0 0.2"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2" effort="10"/></joint>
</robot>
"""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    """What a command says under --json, after status 0."""
    status = main([*words, "--json"])
    shown = capsys.readouterr()
    assert (status, shown.err.replace("done\n", "")) == (0, ""), shown
    return json.loads(shown.out)


def refusal(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """The message of a command that ends with status 2."""
    assert main(list(words)) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(("kind", "model"), FIRST)
def test_a_first_cell_runs_at_once(kind: str, model: str, capsys: pytest.CaptureFixture[str]) -> None:
    made = answer(capsys, "new", kind, "first", "--model", model)
    files = ["cell.toml"] if kind == "base" else ["cell.toml", "main.arps"]
    assert made["files"] == [str(Path("first", name)) for name in files]
    assert sorted(path.name for path in Path("first").iterdir()) == files
    checked = answer(capsys, "check", made["cell"])
    assert checked["warnings"] == []
    assert checked["estimated_time_s"] == made["estimated_time_s"] < 10.0
    summary = answer(capsys, "run", made["cell"], "-o", "out")
    assert summary["outcome"] == "done", summary
    commented(Path(made["cell"]))


@pytest.mark.parametrize("arrangement", runnable())
def test_whatever_a_base_might_begin_with_is_sound(arrangement: str) -> None:
    for signals in (None, (1, 2)):
        for start in base_starts(arrangement, scale=1.3, signals=signals):
            event = '\n[[event]]\nat = "1s"  # when\nsignal = 1  # which\n' if signals else ""
            Path("cell.toml").write_text(head("a cell", "a base") + start.table() + event, "utf-8")
            assert check_cell(Path("cell.toml")).data["warnings"] == []
            commented(Path("cell.toml"))


def commented(cell: Path) -> None:
    """Each key of a cell has its comment, behind it or above it."""
    lines = cell.read_text("utf-8").splitlines()
    keys = [k for k, line in enumerate(lines) if " = " in line and not line.startswith((" ", "#"))]
    assert all("#" in lines[k] or lines[k - 1].startswith("# ") for k in keys), lines


def test_what_cannot_run_is_refused(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """All of our own run; of those that others add some may not."""
    assert set(runnable()) == set(ARRANGEMENTS)
    monkeypatch.setattr(
        "holonom.app.start.base.unsimulated", lambda base: "it flies" if base.name == "sphere" else None
    )
    said = refusal(capsys, "new", "base", "first", "--model", "sphere")
    assert "arrangement 'sphere' cannot be simulated yet: it flies" in said
    assert said.endswith(f"; there is {', '.join(runnable())}\n")
    assert not Path("first").exists()


def test_bad_names_list_what_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    said = refusal(capsys, "new", "arm", "first", "--model", "pumma560")
    assert all(name in said for name in PRESETS)
    assert "did you mean 'puma560'" in said
    said = refusal(capsys, "new", "base", "first", "--model", "puma560")
    assert f"no arrangement of wheels 'puma560'; there is {', '.join(sorted(runnable()))}" in said
    assert "no value of KIND 'amr'; there is agv, arm, base" in refusal(capsys, "new", "amr", "first")
    assert "missing.urdf" in refusal(capsys, "new", "arm", "first", "--model", "missing.urdf")
    assert "required: DIR" in refusal(capsys, "new", "arm")
    assert not Path("first").exists()


def test_nothing_is_overwritten(capsys: pytest.CaptureFixture[str]) -> None:
    Path("used").mkdir()
    for name in ("a", "b", "c", "d"):
        Path("used", name).write_text("mine")
    said = refusal(capsys, "new", "base", "used")
    assert "used holds a, b, c and 1 more; nothing is overwritten: give a folder that is empty" in said
    assert sorted(path.name for path in Path("used").iterdir()) == ["a", "b", "c", "d"]
    Path("file").write_text("mine")
    assert "file: Not a directory; give a folder" in refusal(capsys, "new", "base", "file")
    assert Path("file").read_text() == "mine"


def test_an_empty_folder_is_written_to(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    Path("my robot").mkdir()
    monkeypatch.chdir("my robot")
    assert main(["new", "base", ".", "--quiet"]) == 0
    assert "next: holonom run cell.toml" in capsys.readouterr().out
    assert tomllib.loads(Path("cell.toml").read_text("utf-8"))["cell"]["name"] == "my robot"


def test_a_disk_that_takes_half_of_it_keeps_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The folder of the second file is not there: that is as well as a full disk."""
    files = {"cell.toml": "[cell]\n", "no/such/main.arps": ".END\n"}
    monkeypatch.setattr(new, "_first_sound", lambda *_: (files, {"estimated_time_s": 1.0}))
    assert "cannot write to first: No such file or directory" in refusal(capsys, "new", "arm", "first")
    assert list((tmp_path / "first").iterdir()) == []


def test_a_file_stays_where_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "own.urdf").write_text(URDF)
    made = answer(capsys, "new", "arm", "cells/first", "--model", "robots/own.urdf")
    assert load_cell(made["cell"]).robot[0].model.model.name == "own"
    assert 'model = "../../robots/own.urdf"' in Path(made["cell"]).read_text("utf-8")
    program = Path(made["files"][1]).read_text("utf-8")
    assert "DRIVE 1, 15, 50" in program
    assert "DRAW" not in program, "one joint moves the tool on no line"
    assert answer(capsys, "run", made["cell"], "-o", "out")["outcome"] == "done"


def test_a_file_of_another_place_has_its_whole_path(tmp_path: Path) -> None:
    from holonom.app.start.arm import source_of

    (tmp_path / "own.urdf").write_text(URDF)
    assert source_of(str(tmp_path / "own.urdf"), Path("/no/such/folder"))[0] == str(tmp_path / "own.urdf")


def test_a_xacro_file_that_finds_packages_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("xacro", reason="xacro is not installed; pip install -e '.[xacro]'")
    head = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    text = f'{head}<xacro:include filename="$(find p)/a.xacro"/></robot>'
    (tmp_path / "own.xacro").write_text(text)
    said = refusal(capsys, "new", "arm", "first", "--model", "own.xacro")
    assert "$(find p)" in said
    assert "a cell names no packages: expand the file to a .urdf first" in said


def test_joints_turn_within_their_limits() -> None:
    from holonom.app.start.arm import _turn

    free, narrow = JointLimits(), JointLimits(-0.1, 0.2)
    assert _turn(free, 3.0) == TURN
    assert _turn(narrow, 0.0) == pytest.approx(0.1)
    assert _turn(narrow, 0.15) == pytest.approx(-0.125)


def test_the_best_comes_first_and_without_a_line_last() -> None:
    starts = list(arm_starts("scara", load_model("scara")))
    assert starts[0].home == load_model("scara").poses["ready"]
    assert [start.line for start in (starts[0], starts[-1])] == [(0, 0, 1), None]
    assert reach(load_model("planar2r")) == pytest.approx(2.0)


def test_a_program_that_no_arm_can_run_is_not_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("holonom.app.start.arm.ArmStart.program", lambda *_: ".PROGRAM main()\n  MOVES nowhere\n.END\n")
    said = refusal(capsys, "new", "arm", "first", "--model", "pendulum")
    assert "no program was found that 'pendulum' can run; of the last one tried: main.arps:2:" in said
    assert not Path("first").exists()


def test_the_program_of_an_agv_moves_drives_and_moves(capsys: pytest.CaptureFixture[str]) -> None:
    made = answer(capsys, "new", "agv", "first")
    checked = check_cell(Path(made["cell"])).data
    assert [robot["kind"] for robot in checked["robots"]] == ["arm", "base"]
    assert any("waits for signal 2" in note for note in checked["notes"])
    base, arm = load_cell(made["cell"]).robot
    assert (arm.on, base.start.signal, base.done) == ("agv.top", 1, 2)
    assert base.model.base.mass > sum(body.mass for body in arm.model.model.bodies)


def test_examples_are_found_by_name() -> None:
    assert DEFAULT in examples()
    for name, cell in examples().items():
        assert cell == example(name) == example(cell.parent.name)
        assert cell.is_file()
    with pytest.raises(UnknownName, match=r"no example 'sort_coin'; there is .*sort_coins.*did you mean 'sort_coins'"):
        example("sort_coin")


def test_a_package_without_examples_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for place in ("_PACKAGED", "_IN_CLONE"):
        monkeypatch.setattr(demo, place, tmp_path / "none")
    with pytest.raises(InputError, match=r"no examples in .*none; install holonom anew"):
        examples()


def test_demo_runs_as_run_does(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The same path, with the same options; that it runs is `test_wheel.py`'s."""
    from holonom.app.commands import run as run_command
    from holonom.app.console.answer import Answer

    calls: list[run_command.Options] = []

    def run(options: run_command.Options) -> Answer:
        calls.append(options)
        return Answer("report: there", {})

    monkeypatch.setattr(run_command, "run", run)
    assert main(["demo"]) == main(["demo", "straight_lines", "-o", "out", "--seed", "7", "--quiet"]) == 0
    assert calls == [
        run_command.Options(cell=example(DEFAULT)),
        run_command.Options(cell=example("02_straight_lines"), output=Path("out"), seed=7, quiet=True),
    ]
    assert "no example 'coins'; there is" in refusal(capsys, "demo", "coins")
