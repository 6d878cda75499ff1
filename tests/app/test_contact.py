"""Contact is an event: found by a check, told and stopped in a run; what a wait that does not end waits for is said."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.app.cell.check import check_cell
from holonom.app.cell.rehearse import rehearse
from holonom.app.cell.surroundings import Reach, Surroundings
from holonom.app.console.cli import main
from holonom.app.job import Job
from holonom.app.recording import Recorder, Recording, read_recording
from holonom.app.rig import Ended, Rig, simulated
from holonom.errors import ProgramError
from holonom.lang import poses
from holonom.mechanics.motion import Trajectory
from holonom.sim import Surface, World
from holonom.spatial import pose

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "02_straight_lines" / "cell.toml"
CELL = EXAMPLE.read_text("utf-8").replace('["cascade", "computed_torque"]', '["computed_torque"]')
INTO = "READY\nDRAW 0,0,-100\nDRAW 0,0,-100\nDRAW 0,0,-100\nBREAK\n"
"""The tool stands 237.5 mm over the table: the third line goes into it."""
TABLE = 0.3
STIFF = 2e4
"""Of the ground, N/m."""
COIN = """
[[part]]
name = "coin"
radius = "10mm"
thickness = "2.5mm"
mass = "7g"
pose = { position = ["600mm", "0mm", "300mm"], angle = "0deg" }
"""


def cell(folder: Path, program: str, limits: str = "", more: str = "") -> Path:
    (folder / "straight_lines.arps").write_text(f".PROGRAM main()\n{program}.END\n", "utf-8")
    path = folder / "cell.toml"
    path.write_text(CELL + limits + "\n" + more, "utf-8")
    return path


def job_of(path: Path) -> Job:
    return build_job(load_cell(path), path)


def run(path: Path) -> tuple[Ended, Recording]:
    job = job_of(path)
    with Recorder(path.parent / "recording.mcap") as recorder:
        rig = Rig(job, simulated(job, [arm.settings[-1] for arm in job.arms]), recorder, say=lambda text: None)
        ended = rig.run()
    return ended, read_recording(path.parent / "recording.mcap")


def problems(path: Path) -> tuple[list[str], list[str]]:
    job = job_of(path)
    done = rehearse(job, job.arms[0])
    program = job.arms[0].program
    return done.problems(program), done.warnings(program)


def test_a_check_finds_the_tool_in_the_table_with_line_and_depth(tmp_path: Path) -> None:
    path = cell(tmp_path, INTO)
    home = job_of(path).arms[0]
    depth = 1e3 * (TABLE - (home.arm.fk(home.home)[2, 3] - 0.3))
    with pytest.raises(ProgramError) as caught:
        check_cell(path)
    assert str(caught.value).startswith(
        f"{tmp_path}/straight_lines.arps:5: the tool would be {depth:.1f} mm inside table at "
    )
    assert str(caught.value).endswith("100 % of the motion")


@pytest.mark.parametrize(
    ("place", "name", "depth"),
    [
        ("TRANS(550, 0, 290, 0, 180, 0)", "the tool", 10.0),
        ("TRANS(550, 0, 310, 0, 90, 90)", "a finger", 17.5 + 2.0 - 10.0),  # half of what it opens, and its thickness
        ("TRANS(550, 0, 405, 0, 0, 0)", "the flange", 120.0 - 105.0),  # the hand points up
        ("TRANS(350, 0, 250, 0, 180, 0)", "", 0.0),  # beside the table
    ],
)
def test_whatever_the_hand_brings_into_the_table_is_found(tmp_path: Path, place: str, name: str, depth: float) -> None:
    """Depths by hand, from the gripper of 120 mm that opens by 35 mm."""
    path = cell(tmp_path, "READY\n")
    job = job_of(path)
    arm = job.arms[0].arm
    T = poses.transformation([float(v) for v in place[6:-1].split(",")])
    q = next(q for q in arm.ik(T).q if np.allclose(arm.fk(q), T, atol=1e-9))
    still = Trajectory(1e-3, q[None], 0.0 * q[None], 0.0 * q[None])
    found = Surroundings(arm, job.arms[0].gripper, World(job.surfaces), ()).met_by(still, np.eye(4), Reach(0.035))
    if not name:
        assert found is None
        return
    assert found is not None
    assert found.text.startswith(f"{name} would be ")
    assert 1e3 * found.depth == pytest.approx(depth, abs=0.01)


def test_what_the_hand_holds_is_found_in_the_table(tmp_path: Path) -> None:
    """The coin is held 1 mm over its lower face: 0.5 mm over the table the fingers are free, and the coin is not."""
    pick = "OPENI\nAPPRO TRANS(600,0,301,0,180,0), 40\nMOVES TRANS(600,0,301,0,180,0)\nCLOSEI\nDEPARTS 40\n"
    down = "MOVES TRANS(550,0,299.9,0,180,0)\nDEPARTS 40\n"
    limits = 'contact_force = "15N"\n'
    assert problems(cell(tmp_path, pick + "OPENI\n" + down, limits, COIN)) == ([], [])
    wrong, _ = problems(cell(tmp_path, pick + down, limits, COIN))
    (text,) = wrong
    assert ":7: the held part would be 1.1 mm inside table" in text


def test_a_light_touch_is_a_warning_by_hookes_law(tmp_path: Path) -> None:
    wrong, warned = problems(cell(tmp_path, "MOVE TRANS(550,0,340,0,180,0)\nMOVES TRANS(550,0,297,0,180,0)\n"))
    assert wrong == []
    (text,) = warned
    assert ":3: the tool would be 3.0 mm inside table" in text
    assert text.endswith(f"which presses on it with about {STIFF * 3e-3:.0f} N")


def test_an_obstacle_is_found_by_a_check(tmp_path: Path) -> None:
    wall = '[[obstacle]]\nname = "wall"\npose = { position = ["550mm", "0mm", "450mm"], angle = "0deg" }\n'
    wall += 'size = ["20mm", "400mm", "200mm"]\n'
    wrong, _ = problems(
        cell(
            tmp_path,
            "MOVE TRANS(500,-250,420,0,180,0)\nMOVE TRANS(500,250,420,0,180,0)\n"
            "MOVES TRANS(600,250,420,0,180,0)\nMOVES TRANS(600,0,420,0,180,0)\n",
            "",
            wall,
        )
    )
    assert any("the arm would hit wall at " in text for text in wrong)


def test_a_run_ends_at_a_hard_contact_with_cause_and_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = cell(tmp_path, INTO)
    assert main(["run", str(path), "-o", str(tmp_path / "out"), "--quiet"]) == 1
    said = capsys.readouterr().err
    assert "straight_lines.arps:5: the tool presses on table with " in said
    assert "the cell allows 150 N (limits.contact_force)" in said
    recording = read_recording(tmp_path / "out" / "recording.mcap")
    told = [event for event in recording.events if event.source == "contact"]
    assert [event.level for event in told] == ["warning", "error"]
    assert told[0].text.startswith("touches table with ")
    assert told[0].line == 5
    assert told[-1].time < 2.0, "at once"
    assert "touches table with" in (tmp_path / "out" / "report.html").read_text("utf-8")
    assert json.loads((tmp_path / "out" / "summary.json").read_text("utf-8"))["outcome"] == "failed"


def test_a_wait_that_does_not_end_says_what_it_waits_for(tmp_path: Path) -> None:
    path = cell(tmp_path, INTO, 'contact_force = "10kN"\nsettle_time = "500ms"\n')
    ended, recording = run(path)
    assert ":6: the arm does not come to rest: shoulder is " in ended.reason
    assert "deg from where it was sent, its current is at its limit of " in ended.reason
    assert "A (it waited 0.5 s: limits.settle_time)" in ended.reason
    assert "6 | BREAK" in ended.reason
    assert ended.time < 2.5
    full = [event.text for event in recording.events if event.source == "drive"]
    assert len(full) == 1, "told once"
    assert full[0].startswith("shoulder: its current is at its limit of ")
    assert sum(event.source == "contact" for event in recording.events) == 1


def test_a_contact_within_what_the_cell_allows_is_told_and_goes_on(tmp_path: Path) -> None:
    """Down to 2 mm below the table twice: two contacts, by Hooke's law of 40 N each and a little for the damper."""
    touch = "MOVES TRANS(550,0,298,0,180,0)\nDELAY 0.3\nMOVES TRANS(550,0,320,0,180,0)\n"
    path = cell(
        tmp_path,
        "MOVE TRANS(550,0,320,0,180,0)\nSPEED 20 MMPS ALWAYS\n" + 2 * touch + "BREAK\n",
        'settle_time = "60s"\n',
    )
    job = job_of(path)
    with Recorder(tmp_path / "recording.mcap") as recorder:
        rig = Rig(job, simulated(job, [arm.settings[-1] for arm in job.arms]), recorder, say=lambda text: None)
        ended = rig.run()
    told = [event for event in read_recording(tmp_path / "recording.mcap").events if event.source == "contact"]
    assert len(told) == 2 if ended.fault is None else len(told) >= 1
    assert 10.0 < rig.arms[""].loop.touch < STIFF * 2e-3 + 200.0 * 0.02 + 1.0


def test_the_side_of_a_table_is_met_at_its_edge(tmp_path: Path) -> None:
    """Sideways under the table's top: the run ends at the first tick behind the edge, and nothing pushes up.

    A spring of the whole depth, 70 mm, would push at once with 1400 N where 150 N are allowed.
    """
    program = "MOVE TRANS(350,0,330,0,180,0)\nDRAW 0,0,-100\nDRAW 200,0,0\nBREAK\n"
    ended, recording = run(cell(tmp_path, program))
    assert ended.fault is not None
    assert "the tool runs into the side of table, 70 mm below its top" in str(ended.fault)
    assert ":4:" in str(ended.fault) or "DRAW 200,0,0" in str(ended.fault)
    assert recording.contacts.force.max(initial=0.0) == 0.0


def test_the_table_ends_at_its_edge(tmp_path: Path) -> None:
    """Beside the table there is nothing to press on: an arm may reach below its height there."""
    path = cell(tmp_path, "MOVE TRANS(350,100,320,0,180,0)\nMOVES TRANS(350,100,270,0,180,0)\nBREAK\n")
    ended, recording = run(path)
    assert ended.fault is None, ended.reason
    assert not [event for event in recording.events if event.source == "contact"]


def test_ideal_joints_do_not_go_through_a_table(tmp_path: Path) -> None:
    path = cell(tmp_path, INTO)
    path.write_text(path.read_text("utf-8").replace('controllers = ["computed_torque"]', 'drives = "ideal"'), "utf-8")
    ended, _ = run(path)
    assert ":5: the tool is " in ended.reason
    assert "mm inside table, which ideal joints do not feel" in ended.reason


def test_the_time_limit_says_what_a_wait_waits_for(tmp_path: Path) -> None:
    path = cell(tmp_path, INTO, 'contact_force = "10kN"\nsettle_time = "60s"\n')
    path.write_text(path.read_text("utf-8").replace('time_limit = "120s"', 'time_limit = "2s"'), "utf-8")
    ended, _ = run(path)
    assert "not done after 2 s" in ended.reason
    assert "BREAK (the arm does not come to rest: shoulder is " in ended.reason


SHELF = '[[surface]]\nname = "shelf"\npose = { position = ["400mm", "-300mm", "600mm"], angle = "0deg" }\n'
SHELF += 'size = ["400mm", "600mm"]\n'


def test_under_a_shelf_and_over_a_table_is_free(tmp_path: Path) -> None:
    """From the side under the shelf at half its height, and into it from above, by check and by run."""
    table = '[table]\npose = { position = ["400mm", "-300mm", "300mm"], angle = "0deg" }\nsize = ["400mm", "600mm"]\n'
    place = table.replace("[table]", '[[surface]]\nname = "table"')
    under = (
        "MOVE TRANS(340,150,420,0,180,0)\nMOVES TRANS(450,150,420,0,180,0)\nMOVES TRANS(340,150,420,0,180,0)\nBREAK\n"
    )
    path = cell(tmp_path, under, "", SHELF)
    path.write_text(path.read_text("utf-8").replace(table, place), "utf-8")
    assert len(job_of(path).surfaces) == 2
    found = [text for text in problems(path)[0] if "the tool" in text]
    assert found == []
    ended, recording = run(path)
    assert not [event for event in recording.events if event.source == "contact"], ended.reason


def test_which_surface_is_under_a_point() -> None:
    shelf, table = (Surface(name, pose((0.0, 0.0, z)), (1.0, 1.0)) for name, z in (("shelf", 0.6), ("table", 0.3)))
    world = World([shelf, table])
    for z, before, under in (
        (0.9, None, shelf), (0.45, None, table), (0.58, None, shelf), (0.45, shelf, shelf), (0.1, None, shelf),
        (0.28, table, table),
    ):  # fmt: skip
        assert world.under((0.1, 0.1, z), before) is under, z
    assert world.under((0.6, 0.0, 0.4)) is None
