"""A rig: several robots in one clock, signals between them, stops, what is recorded."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from jobs import PUMA, arm_job, base_job, job, line

from holonom.app.job import Job, Mount, Obstacle, SensorJob, SignalEvent, Task
from holonom.app.recording import Recorder, Recording, read_recording
from holonom.app.recording.reader import read_robots
from holonom.app.rig import Ended, Ending, Rig, simulated
from holonom.geometry import Box, Cylinder
from holonom.sim import BaseFault, Disc, Gripper, Surface
from holonom.spatial import inverse, pose

SIGNALLED = """
.PROGRAM main()
  TYPE "waits"
  WAIT SIG(5)
  SIGNAL 6
  TYPE "goes on"
.END
"""
PAUSES = ".PROGRAM main()\n  PAUSE\n.END\n"
FOREVER = ".PROGRAM main()\n  10 DRIVE 1, 5, 50\n  DRIVE 1, -5, 50\n  GOTO 10\n.END\n"


def run(what: Job, path: Path, **asked: object) -> tuple[Ended, Rig, Recording]:
    loops = simulated(what, [arm.settings[-1] for arm in what.arms])
    with Recorder(path / "recording.mcap") as recorder:
        rig = Rig(what, loops, recorder, say=typed.append)
        ended = rig.run(**asked)  # type: ignore[arg-type]
    return ended, rig, read_robots(path / "recording.mcap")[""]


typed: list[str] = []


@pytest.fixture(autouse=True)
def _nothing_typed() -> None:
    typed.clear()


def test_a_base_drives_its_path(tmp_path: Path) -> None:
    ended, rig, recording = run(job(base_job(line())), tmp_path)
    assert (ended.ending, ended.reason) == (Ending.DONE, "path driven")
    assert ended.time == pytest.approx(line().path.time[-1], abs=2e-3)
    np.testing.assert_allclose(recording.true_base.pose[-1], [1.0, 0.0, 0.0], atol=0.01)
    assert rig.bases[""].driven == 1.0
    assert [e.text for e in recording.events] == ["path driven"]


def test_robots_wait_for_each_other_by_signals(tmp_path: Path) -> None:
    """The arm waits for the base's end; another base waits for the arm."""
    first = base_job(dataclasses.replace(line(0.5), done=5), "first")
    second = base_job(dataclasses.replace(line(0.3), after=6), "second", pose=np.array([0.0, 1.0, 0.0]))
    ended, _, recording = run(job(first, second, arm_job(SIGNALLED, "puma")), tmp_path)
    assert ended.ending is Ending.DONE
    assert typed == ["waits", "goes on"]
    at = {(signal.number, signal.on): signal.time for signal in recording.signals}
    length = line(0.5).path.time[-1]
    assert length <= at[5, True] <= length + 0.03
    assert at[5, True] <= at[6, True] <= at[5, True] + 0.03
    moving = read_recording(tmp_path / "recording.mcap", robot="second").true_base
    begins = moving.time[np.argmax(np.abs(moving.twist[:, 0]) > 0.01)]
    assert begins > at[6, True]
    assert {"first", "second", "puma"} <= set(recording.robots)


def test_events_switch_signals(tmp_path: Path) -> None:
    ended, _, recording = run(job(arm_job(SIGNALLED), events=(SignalEvent(1.5, 5, True),)), tmp_path)
    assert ended.ending is Ending.DONE
    assert 1.5 <= ended.time < 1.6
    assert next(s.time for s in recording.signals if s.number == 5 and s.on) == pytest.approx(1.5, abs=0.011)


def test_a_program_at_pause_is_paused(tmp_path: Path) -> None:
    ended, _, _ = run(job(arm_job(PAUSES)), tmp_path)
    assert (ended.ending, ended.fault) == (Ending.PAUSED, None)


def test_velocities_are_followed(tmp_path: Path) -> None:
    rows = np.array([[0.0, 0.3, 0.0, 0.0], [1.0, 0.0, 0.3, 0.5], [2.0, 0.0, 0.0, 0.0]])
    ended, _, recording = run(job(base_job(Task(velocities=rows))), tmp_path)
    assert ended.ending is Ending.DONE
    base = recording.true_base
    for time, twist in ((0.9, rows[0, 1:]), (1.9, rows[1, 1:])):
        np.testing.assert_allclose(base.twist[np.searchsorted(base.time, time)], twist, atol=0.05)
    assert 2.0 < ended.time < 3.0


def test_the_time_limit_names_the_program_line(tmp_path: Path) -> None:
    ended, _, recording = run(job(arm_job(FOREVER), time_limit=1.0), tmp_path)
    assert ended.ending is Ending.FAILED
    assert "not done after 1 s of simulated time" in ended.reason
    assert "DRIVE" in ended.reason or "GOTO" in ended.reason
    assert np.abs(recording.true_joints.velocity[-1]).max() < 0.02, "it stopped on its path"


def test_an_operator_stops_all_on_their_paths(tmp_path: Path) -> None:
    asked = iter([False] * 40 + [True] * 1000)
    what = job(base_job(line(3.0), "agv"), arm_job(FOREVER, "puma"))
    ended, rig, recording = run(what, tmp_path, stop=lambda: next(asked))
    assert ended.ending is Ending.STOPPED
    assert rig.bases["agv"].standing
    assert rig.arms["puma"].machine.stopped
    assert any(event.source == "operator" for event in recording.events)
    track = read_recording(tmp_path / "recording.mcap", robot="agv").true_base
    assert np.abs(track.pose[:, 1]).max() < 0.01, "on the path"


def test_what_does_not_stop_in_time_is_closed_all_the_same(tmp_path: Path) -> None:
    asked = iter([False] * 40 + [True] * 1000)
    ended, _, recording = run(job(base_job(line(3.0))), tmp_path, stop=lambda: next(asked), overdue=lambda: True)
    assert ended.ending is Ending.STOPPED
    assert recording.ended == "complete"


def test_a_jammed_wheel_fails_the_run(tmp_path: Path) -> None:
    robot = base_job(line(3.0), "agv", faults=(BaseFault(1.0, 0, "blocked"),))
    ended, rig, recording = run(job(robot, base_job(line(3.0), "other", pose=np.array([0.0, 2.0, 0.0]))), tmp_path)
    assert ended.ending is Ending.FAILED
    assert ended.reason.startswith("agv: stopped with a jammed wheel after")
    assert 0.1 < rig.bases["agv"].driven < 0.9
    assert rig.bases["other"].standing
    texts = [event.text for event in recording.events]
    assert "the motor of wheel 1 jams" in texts
    assert any(text.startswith("the motor of wheel 1 does not do as told; it is jammed") for text in texts)


@pytest.mark.parametrize("size", [(0.1, 0.1, 0.5), None])
def test_an_obstacle_is_not_driven_through(tmp_path: Path, size: tuple[float, float, float] | None) -> None:
    wall = Obstacle("wall", pose((0.6, 0.0, 0.2)), Box(size) if size else Cylinder(0.05, 0.4))
    ended, _, recording = run(job(base_job(line(1.0)), obstacles=(wall,)), tmp_path)
    assert ended.ending is Ending.FAILED
    assert "the base hit wall" in ended.reason
    assert recording.true_base.pose[-1, 0] < 0.6


def test_a_base_is_not_driven_through_another(tmp_path: Path) -> None:
    """The one that moves is told to have hit the other, when their outlines meet."""
    stands = base_job(Task(hold=60.0), "stands", pose=np.array([0.8, 0.0, 0.0]))
    ended, rig, _ = run(job(base_job(line(), "drives"), stands), tmp_path)
    assert (ended.ending, ended.reason) == (Ending.FAILED, "drives: it hit stands")
    x = rig.bases["drives"].loop.plant.pose[0]
    assert 0.8 - 3.0 * 0.079 <= x < 0.8


def test_who_is_not_done_in_time_says_what_it_waits_for(tmp_path: Path) -> None:
    drives = base_job(dataclasses.replace(line(), after=5), "waits")
    holds = base_job(Task(hold=60.0), "holds", pose=np.array([0.0, 3.0, 0.0]))
    ended, _, _ = run(job(drives, holds, time_limit=0.5), tmp_path)
    assert "waits: it waits for signal 5" in ended.reason
    assert "holds: under way since 0 s" in ended.reason


def test_an_arm_does_not_go_through_an_obstacle(tmp_path: Path) -> None:
    T = PUMA.fk(np.radians([60.0, 45.0, -180.0, 0.0, -45.0, 0.0]))
    post = Obstacle("post", pose((T[0, 3], T[1, 3], T[2, 3])), Cylinder(0.05, 0.3))
    program = ".PROGRAM main()\n  DRIVE 1, 90, 50\n.END\n"
    ended, _, _ = run(job(arm_job(program), obstacles=(post,)), tmp_path)
    assert ended.ending is Ending.FAILED
    assert "the arm hit post" in ended.reason


def test_an_arm_on_a_base_holds_a_part_while_it_drives(tmp_path: Path) -> None:
    """Its own base is where the base truly is; a held part goes along, and is placed in the world."""
    tool = pose((0.0, 0.0, 0.12))
    arm = PUMA.with_tool(tool)
    mount = Mount(np.eye(4), "agv", "top")
    start = pose((0.0, 0.0, 0.3)) @ arm.fk(np.radians([0.0, 45.0, -180.0, 0.0, -45.0, 0.0]))
    part = Disc("part", 0.01, 0.02, 0.05, pose(start[:3, 3] - [0.0, 0.0, 0.005]))
    table = Surface("table", pose((start[0, 3], start[1, 3], start[2, 3] - 0.015)), (0.1, 0.1))
    there = Surface("there", pose((start[0, 3] + 1.0, start[1, 3], start[2, 3] - 0.02)), (0.2, 0.2))
    program = ".PROGRAM main()\n  CLOSEI\n  SIGNAL 5\n  WAIT SIG(6)\n  OPENI\n  DELAY 0.5\n.END\n"
    puma = arm_job(program, "puma", arm=arm, mount=mount, gripper=Gripper(0.035, 0.008, 0.002, 0.35))
    agv = base_job(dataclasses.replace(line(1.0), after=5, done=6), "agv")
    what = job(agv, puma, parts=(part,), surfaces=(table, there))
    ended, rig, recording = run(what, tmp_path)
    assert ended.ending is Ending.DONE, ended.reason
    texts = [event.text for event in recording.events]
    assert "grasped part" in texts
    assert "released part" in texts
    end = rig.world.discs[0].pose
    assert end[0, 3] == pytest.approx(start[0, 3] + 1.0, abs=0.02)
    assert end[2, 3] == pytest.approx(there.pose[2, 3] + 0.01, abs=1e-6)
    assert what.parts[0].pose[0, 3] == pytest.approx(start[0, 3]), "the job stays as it was"
    frames = recording.frames
    tools, bases = frames["puma/tool"].poses(), frames["agv/base_link"].poses()
    k = len(bases) // 2
    at = int(np.searchsorted(frames["puma/tool"].time, frames["agv/base_link"].time[k]))
    np.testing.assert_allclose((inverse(bases[k]) @ tools[at])[:3, 3], start[:3, 3], atol=0.02)


def test_sensors_of_the_cell_are_recorded(tmp_path: Path) -> None:
    class Distance:
        def read(self, truth: object, rng: np.random.Generator) -> np.ndarray:
            return np.array([np.hypot(*truth.pose[:2]), rng.standard_normal()])  # type: ignore[attr-defined]

    sensor = SensorJob("range", "", "distance", Distance())
    _, _, recording = run(job(base_job(line(0.5)), sensors=(sensor,)), tmp_path)
    track = recording.tracks["/measured/sensors/range"]
    assert track.fields["values"].shape[1] == 2
    assert track.fields["values"][-1, 0] == pytest.approx(0.5, abs=0.01)


def test_equal_runs_give_equal_bytes(tmp_path: Path) -> None:
    files = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        run(job(base_job(line(0.3), "agv"), arm_job(PAUSES, "puma")), tmp_path / name)
        files.append((tmp_path / name / "recording.mcap").read_bytes())
    assert files[0] == files[1]
