"""`holonom check`: what it finds without running anything, and what it leaves alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from cells import EXAMPLE, CellCopy

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.app.cell.build.taught import taught_problems
from holonom.app.cell.rehearse import Rehearsal, rehearse
from holonom.app.console.cli import main
from holonom.lang import load_program


def rehearsed(path: Path) -> Rehearsal:
    job = build_job(load_cell(path), path)
    return rehearse(job, job.arms[0])


JOB = build_job(load_cell(EXAMPLE / "cell.toml"), EXAMPLE / "cell.toml").arms[0]
ARM, HOME = JOB.arm, JOB.home.tolist()


@pytest.fixture
def cell(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> CellCopy:
    return CellCopy(tmp_path, capsys)


def test_a_good_cell(cell: CellCopy) -> None:
    before = {path: path.read_bytes() for path in cell.folder.iterdir()}
    status, text = cell.call("check", "--json")
    assert status == 0, text
    data = json.loads(text)
    assert (data["kind"], data["parts"], data["warnings"]) == ("cell", 24, [])
    assert data["motions"] == 2 + 24 * 6
    assert {path: path.read_bytes() for path in cell.folder.iterdir()} == before
    assert cell.call("check")[1].count("24 parts seen") == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["01_sort_coins", "02_straight_lines"])
def test_the_estimate_is_a_little_above_the_simulated_time(name: str, example_run: Callable[[str], Path]) -> None:
    """Without blending it must be longer; joints and lines are planned alike."""
    path = EXAMPLE.parent / name / "cell.toml"
    done = rehearsed(path)
    assert done.failures == ()
    simulated = json.loads((example_run(name) / "summary.json").read_text("utf-8"))["simulated_time_s"]
    assert simulated < done.machine.time() < 1.4 * simulated


def test_the_rehearsal_ends_where_the_program_ends() -> None:
    machine = rehearsed(EXAMPLE / "cell.toml").machine
    np.testing.assert_allclose(machine.joints(), HOME, atol=1e-12)
    assert machine.typed[-3:] == ["small: 18", "medium: 2", "large: 4"]


def test_every_motion_that_cannot_be_made_has_its_line(cell: CellCopy) -> None:
    cell.edit("sort_coins.arps", "MOVES spot", "MOVES SHIFT(spot BY 500, 0, 0)")
    cell.edit("sort_coins.arps", "READY  ", "DRIVE 5, -150, 50")
    status, text = cell.call("check")
    assert status == 2
    first, second = text.removeprefix("holonom: error: ").splitlines()
    assert first.startswith(cell.line("sort_coins.arps", "DRIVE 5") + ": wrist_bend is to go to ")
    assert second.startswith(cell.line("sort_coins.arps", "MOVES SHIFT") + ": ")
    assert "out of the arm's reach" in second
    assert second.endswith("(24 times)")


def test_a_coin_out_of_reach(cell: CellCopy) -> None:
    cell.edit("cell.toml", r'position = \["400mm"', 'position = ["640mm"')
    status, text = cell.call("check")
    assert status == 2
    assert cell.line("sort_coins.arps", "APPRO coin") + ": the tool cannot reach" in text


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ("WHILE TRUE DO\n  pitch = 36\n  END", "a loop that neither moves nor waits"),
        ("pitch = 36 / 0", "division by zero"),
        ("WAIT SIG(9)", "not done after 300 s, the cell's time_limit"),
        ("WHILE TRUE DO\n  READY ; again\n  END", "not done after 300 s, the cell's time_limit"),
    ],
)
def test_a_program_that_fails_or_does_not_end(cell: CellCopy, wrong: str, said: str) -> None:
    cell.edit("sort_coins.arps", "VPICTURE", wrong)
    status, text = cell.call("check")
    assert status == 2
    assert said in text
    assert any(cell.line("sort_coins.arps", line) + ": " in text for line in wrong.splitlines())


def test_all_findings_come_together(cell: CellCopy) -> None:
    cell.edit("sort_coins.loc", "498", "1498")
    cell.edit("sort_coins.arps", "READY  ", "DRIVE 5, -150, 50")
    status, text = cell.call("check")
    assert status == 2
    places = [line.split(": ")[0] for line in text.removeprefix("holonom: error: ").splitlines()]
    assert places == [
        cell.line("sort_coins.loc", "1498"),
        cell.line("sort_coins.arps", "DRIVE 5"),
        cell.line("sort_coins.arps", "APPRO spot"),
        cell.line("sort_coins.arps", "MOVES spot"),
    ]


def test_a_program_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "loop.arps"
    path.write_text(".PROGRAM main()\nagain: x = 1\nREADY\n.END\n.PROGRAM other()\n.END\n", "utf-8")
    assert main(["check", str(path)]) == 0
    text = capsys.readouterr().out
    assert text.startswith(
        f"{path}: no errors; programs: main, other\nwarning: {path}:2:1: label 'again' is never used"
    )
    assert main(["check", str(path), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["kind"], data["file"], len(data["warnings"])) == ("program", str(path), 1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (".PROGRAM main()\nMOVE place\n.END\n", ":2:6: location 'place' is never given a value\n  2 | MOVE place\n"),
        (".PROGRAM main()\nx = (1\n.END\n", ":2:7: "),
        (None, ": cannot be read: No such file"),
    ],
)
def test_a_program_with_errors(text: str | None, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "main.arps"
    if text is not None:
        path.write_text(text, "utf-8")
    assert main(["check", str(path)]) == 2
    assert f"holonom: error: {path}{said}" in capsys.readouterr().err


def taught(folder: Path, program: str, locations: str) -> list[str]:
    (folder / "p.arps").write_text(program if ".PROGRAM" in program else f".PROGRAM p()\n{program}\n.END\n", "utf-8")
    file = folder / "p.loc"
    file.write_text(locations, "utf-8")
    return list(taught_problems(ARM, HOME, load_program(folder / "p.arps"), file))


FAR = "far = 5000, 0, 300, 0, 180, 0\n"


@pytest.mark.parametrize(
    "program",
    [
        "MOVE far",
        "APPROS far, 50",
        "SET a = far\nMOVE a",
        "MOVE SHIFT(far BY 0, 0, 10)",
        "IF SIG(1) THEN\nMOVE far\nEND",
        "x = DX(far)",
        "READY",
        ".PROGRAM p()\nCALL q(far)\n.END\n.PROGRAM q(a)\nMOVE a\n.END\n",
    ],
)
def test_places_have_to_be_in_reach(program: str, tmp_path: Path) -> None:
    (problem,) = taught(tmp_path, program, f"; places\n\n{FAR}near = 450, 0, 400, 0, 180, 0\n")
    assert problem.startswith(
        f"{tmp_path / 'p.loc'}:3: taught location 'far': the tool cannot reach (5000.0, 0.0, 300.0)"
    )


@pytest.mark.parametrize(
    "program",
    [
        "MOVE far:HERE",
        "SET a = HERE:far\nMOVE a",
        "SET a[1] = far\nFOR k = 1 TO 1\nMOVE a[k]:NULL()\nEND",
        "TOOL far",
        "BASE far",
        "SET a = far\nSET b = a\nTOOL b",
        "SET a = INVERSE(far)",
        ".PROGRAM p()\nCALL q(far)\n.END\n.PROGRAM q(a)\nCALL r(1, a)\n.END\n.PROGRAM r(x, a)\nMOVE a:HERE\n.END\n",
    ],
)
def test_frames_offsets_and_tools_need_not_be(program: str, tmp_path: Path) -> None:
    assert taught(tmp_path, program, FAR) == []


def test_elements_and_precision_points(tmp_path: Path) -> None:
    locations = "a[1, 2] = 5000, 0, 0, 0, 180, 0\n#p = 0, 0, 95, 0, 0, 0\n#q = 0, 45, -180, 0, -45, 0\n#r[3] = 1, 2\n"
    found = taught(tmp_path, "TOOL NULL()\nMOVE #p\nMOVE a[1, 2]\nMOVE #r[3]", locations)
    file = tmp_path / "p.loc"
    assert found == [
        f"{file}:2: taught location '#p': 95 deg came for elbow; -225 to 45 deg is allowed",
        f"{file}:4: taught location '#r[3]': 2 joint values came; the arm has 6 joints",
    ]
    (found,) = taught(tmp_path, "MOVE a[1, 2]", locations.splitlines()[0])
    assert found.startswith(f"{file}:1: taught location 'a[1,2]': the tool cannot reach")


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("arm.urdf", "a file of type '.urdf'"),
        ("notes.TXT", "a file of type '.TXT'"),
        ("cell.json", "a file of type '.json'"),
        ("program", "a file without an ending"),
        ("", "a folder"),
    ],
)
def test_a_file_of_another_type_is_refused_by_name(tmp_path, capsys, name, what):
    path = tmp_path / name
    if name:
        path.write_text("<robot name='x'/>", encoding="utf-8")
    assert main(["check", str(path)]) == 2
    told = capsys.readouterr().err
    takes = "holonom check takes a program (.arps), or the file of a cell, motor or axis (.toml)"
    assert f"{path}: {what}; {takes}" in told
    assert "Traceback" not in told


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("cell.toml", b"<robot name='x'/>", "not TOML"),
        ("cell.toml", b"\x89PNG\r\n\x1a\n\xff", "not UTF-8"),
        ("program.arps", b"\x89PNG\r\n\x1a\n\xff", "not UTF-8 text"),
        ("program.arps", b"<robot name='x'/>", "program.arps:1"),
    ],
)
def test_something_else_under_a_right_ending_is_refused_too(tmp_path, capsys, name, text, what):
    (tmp_path / name).write_bytes(text)
    assert main(["check", str(tmp_path / name)]) == 2
    assert what in capsys.readouterr().err


def test_a_program_is_told_which_cell_to_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    program = EXAMPLE / "sort_coins.arps"
    assert main(["run", str(program), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert f"is a program; run the cell that names it: holonom run {EXAMPLE / 'cell.toml'}" in said
    assert not (tmp_path / "out").exists()
    assert main(["check", str(program)]) == 0
    assert f"note: its motions are checked with the cell that names it: holonom check {EXAMPLE / 'cell.toml'}" in (
        capsys.readouterr().out
    )
    alone = tmp_path / "alone.arps"
    alone.write_text(program.read_text("utf-8"), "utf-8")
    assert main(["run", str(alone)]) == 2
    assert "a cell says which robot runs it; holonom new arm FOLDER writes one" in capsys.readouterr().err
    for name, todo in (
        ("r.urdf", "new arm FOLDER --model"),
        ("r.mcap", "holonom report"),
        ("p.loc", "a cell names"),
    ):
        assert main(["run", str(tmp_path / name)]) == 2
        assert todo in capsys.readouterr().err
