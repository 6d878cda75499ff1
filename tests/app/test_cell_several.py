"""Several robots in a cell: two arms, six bases, an arm on a base; what they wait for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cell_files import ABOUT, CELLS, built, drawn, write

from holonom.app.cell.check import check_cell
from holonom.app.cell.rehearse import end_of, rehearse
from holonom.errors import CellError


def test_what_comes_after_the_time_limit_is_said(tmp_path: Path) -> None:
    text = (CELLS / "six_bases.toml").read_text("utf-8") + '\n[[event]]\nat = "31s"\nsignal = 3\n'
    assert "event of signal 3 at 31 s: the cell's time_limit is 30 s" in built(write(tmp_path, text)).notes


def test_ideal_drives_have_no_motors_that_break(tmp_path: Path) -> None:
    text = (CELLS / "six_bases.toml").read_text("utf-8")
    ideal = next(table for table in text.split("[[robot]]") if 'drives = "ideal"' in table)
    name = ideal.partition('name = "')[2].partition('"')[0]
    wheel = next(base for base in built(CELLS / "six_bases.toml").bases if base.name == name).base.driven[0]
    text += f'\n[[fault]]\ntime = "1s"\nrobot = "{name}"\nkind = "motor_dead"\nwheel = "{wheel}"\n'
    with pytest.raises(CellError, match=rf"fault\[\d+\].kind: it came; the ideal drives of {name} have no motors"):
        built(write(tmp_path, text))


def test_two_arms() -> None:
    path = CELLS / "two_arms.toml"
    job = built(path)
    assert [(arm.name, arm.drives, arm.mount) for arm in job.arms] == [
        ("left", "motors", None),
        ("right", "motors", None),
    ]
    np.testing.assert_allclose(np.array(job.arms[1].arm.model.base)[:3, 3], [1.2, 0, 0])
    assert [arm.ground.height for arm in job.arms] == [0.3, 0.3]
    drawn(job)
    assert {"left/link1", "right/link1", "left/finger_left", "disc"} <= set(job.scene.frames())
    pedestals = [
        shape for shape in job.scene.shapes if shape.frame == "world" and getattr(shape, "end", (0, 0, 0))[0] > 1
    ]
    assert len(pedestals) == 3  # the right arm's stands where that arm does
    answer = check_cell(path)
    assert [(robot["name"], robot["motions"]) for robot in answer.data["robots"]] == [("left", 7), ("right", 7)]
    assert len([note for note in answer.data["notes"] if "waits for signal" in note]) == 2


def test_six_bases() -> None:
    path = CELLS / "six_bases.toml"
    job = built(path)
    assert [base.base.name for base in job.bases] == [
        "omni",
        "omni",
        "mecanum",
        "mecanum",
        "differential",
        "differential",
    ]
    assert [base.drives for base in job.bases] == ["from_limits"] * 5 + ["ideal"]
    assert job.bases[2].task.after == job.bases[0].task.done == 1
    np.testing.assert_allclose([base.pose[1] for base in job.bases], range(6), atol=1e-12)
    drawn(job)
    assert {f"{base.name}/wheel_1" for base in job.bases} <= set(job.scene.frames())
    assert len(check_cell(path).data["robots"]) == 6


def test_an_arm_on_a_base() -> None:
    path = CELLS / "arm_on_base.toml"
    job = built(path)
    (arm,), (agv,) = job.arms, job.bases
    assert arm.mount is not None
    assert (arm.mount.robot, arm.mount.frame) == ("agv", "top")
    np.testing.assert_allclose(arm.arm.model.base, np.eye(4))  # its own base is where the mount says
    deck = agv.frames["top"][2, 3]
    assert deck == pytest.approx(2.6 * 0.075)
    assert max(s.end[2] for s in job.scene.shapes if s.frame == "agv/base_link" and hasattr(s, "end")) >= deck
    assert arm.ground.height == pytest.approx(0.3 - deck)
    np.testing.assert_allclose(end_of(agv), [0, 1, 0], atol=1e-9)
    drawn(job)
    done = rehearse(job, arm)
    assert (done.failures, done.problems(arm.program)) == ((), [])
    assert done.notes == ("it waits for signal 6 at line 14; taken as given by robot 'agv'",)


def test_the_arm_could_not_reach_the_goal_from_where_the_base_starts(tmp_path: Path) -> None:
    for name in ("arm_on_base.toml", "arm_on_base.arps"):
        text = (CELLS / name).read_text("utf-8").replace("  WAIT SIG(6)\n", "")
        (tmp_path / name).write_text(text, "utf-8")
    job = built(tmp_path / "arm_on_base.toml")
    assert any("cannot reach" in line for line in rehearse(job, job.arms[0]).problems(job.arms[0].program))


def test_events_give_signals_at_their_times(tmp_path: Path) -> None:
    program = ".PROGRAM main()\n  WAIT SIG(9)\n  READY\n  WAIT SIG(-9)\n.END\n"
    (tmp_path / "p.arps").write_text(program, "utf-8")
    events = '[[event]]\nat = "5s"\nsignal = 9\n[[event]]\nat = "20s"\nsignal = 9\non = false\n'
    text = f"{ABOUT}[[robot]]\nmodel = 'puma560'\nprogram = 'p.arps'\n"
    job = built(write(tmp_path, text + events))
    done = rehearse(job, job.arms[0])
    assert done.failures == done.notes == ()
    assert done.machine.time() == pytest.approx(20.0, abs=0.05)
    job = built(write(tmp_path, text))
    assert "not done after 60 s" in rehearse(job, job.arms[0]).failures[0]


def test_a_hand_that_is_not_there(tmp_path: Path) -> None:
    (tmp_path / "p.arps").write_text(".PROGRAM main()\n  OPENI\n.END\n", "utf-8")
    job = built(write(tmp_path, f"{ABOUT}[[robot]]\nmodel = 'ur5e'\nprogram = 'p.arps'\n"))
    (failure,) = rehearse(job, job.arms[0]).failures
    assert "p.arps:2:" in failure
    assert "this arm has no hand" in failure


def test_where_velocities_end(tmp_path: Path) -> None:
    """Arcs, against many small steps."""
    text = (CELLS / "six_bases.toml").read_text("utf-8")
    steps = '{ at = "0s", vx = "0.3m/s", vy = "0.2m/s", w = "0.7rad/s" }, { at = "1.5s", vy = "0.1m/s" }, { at = "2s" }'
    text = text.replace(
        '{ at = "0s", vx = "0.5m/s", vy = "0.1m/s" }, { at = "2s", w = "60deg/s" }, { at = "3s" }', steps
    )
    base = built(write(tmp_path, text)).bases[1]
    x, y, angle = base.pose
    dt = 1e-4
    for k in range(20000):
        vx, vy, w = base.task.velocities[0 if k < 15000 else 1, 1:]
        turn = angle + 0.5 * w * dt
        x, y = x + dt * (vx * np.cos(turn) - vy * np.sin(turn)), y + dt * (vx * np.sin(turn) + vy * np.cos(turn))
        angle += w * dt
    np.testing.assert_allclose(end_of(base), [x, y, angle], atol=1e-7)
