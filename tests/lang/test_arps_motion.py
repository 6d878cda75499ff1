"""Motion instructions: what the machine is asked, in SI, and when."""

from __future__ import annotations

import numpy as np
import pytest
from arps_machine import FakeMachine, run

from holonom.errors import ProgramFault
from holonom.lang import Configuration, Motion, Part, compile_program, poses, read_locations, start, step

P = "SET p = TRANS(400, -100, 300, 0, 180, 0)\n"
T = poses.transformation((400, -100, 300, 0, 180, 0))


def motions(source: str, **options: int) -> list[Motion]:
    return run(P + source, FakeMachine(**options))[0].motions


@pytest.mark.parametrize(("word", "kind"), [("MOVE", "joint"), ("MOVES", "line")])
def test_move(word: str, kind: str) -> None:
    (motion,) = motions(f"{word} p")
    assert motion.kind == kind
    assert motion.pose == pytest.approx(T)
    assert motion.joints is None
    assert (motion.speed, motion.speed_mps, motion.acceleration) == (1.0, None, 1.0)
    assert motion.configuration == Configuration(None, None, None)
    assert (motion.blend, motion.tolerance, motion.line) == (True, "fine", 3)


@pytest.mark.parametrize(("word", "kind"), [("APPRO", "joint"), ("APPROS", "line")])
def test_approach_draws_back_along_the_tool(word: str, kind: str) -> None:
    (motion,) = motions(f"{word} p, 50")
    assert motion.kind == kind
    assert motion.pose[:3, 3] == pytest.approx([0.4, -0.1, 0.35])
    assert motion.pose[:3, :3] == pytest.approx(T[:3, :3])


@pytest.mark.parametrize(("word", "kind"), [("DEPART", "joint"), ("DEPARTS", "line")])
def test_depart_is_the_way_back_of_an_approach(word: str, kind: str) -> None:
    approach, _, depart = motions(f"APPRO p, 50\nMOVES p\n{word} 50", motion_ticks=4)
    assert depart.kind == kind
    assert depart.pose == pytest.approx(approach.pose)


def test_approach_of_a_tilted_tool() -> None:
    (motion,) = motions("MOVE NULL\nAPPRO TRANS(0, 0, 0, 0, 90, 0), 10")[1:]
    assert motion.pose[:3, 3] == pytest.approx([-0.01, 0, 0])


def test_draw_is_along_the_base_axes() -> None:
    _, motion = motions("MOVE p\nDRAW 10, , -20")
    assert motion.kind == "line"
    assert motion.pose[:3, 3] == pytest.approx([0.41, -0.1, 0.28])
    assert motion.pose[:3, :3] == pytest.approx(T[:3, :3])


def test_precision_points_and_drive() -> None:
    source = "MOVE #PPOINT(10, 20, 30, 0, 0, 0)\nMOVES #a\nDRIVE 2, -20, 50\nSPEED 30\nHERE #b\nMOVE #b"
    locations = read_locations("#a = 0, 90, 0, 0, 0, 0", "x.loc")
    program = compile_program(f".PROGRAM m()\n{source}\n.END", "x.arps", locations)
    first, second, third, fourth = run(program, FakeMachine(motion_ticks=2))[0].motions
    assert np.rad2deg(first.joints) == pytest.approx([10, 20, 30, 0, 0, 0])
    assert (second.kind, second.pose) == ("line", None)
    assert np.rad2deg(third.joints) == pytest.approx([0, 70, 0, 0, 0, 0])
    assert third.speed == 0.5
    assert fourth.joints == pytest.approx(third.joints)
    assert fourth.speed == pytest.approx(0.3)


def test_ready_goes_to_the_joints_of_the_machine() -> None:
    (motion,) = motions("READY")
    assert motion.joints == pytest.approx([0, 1, -1, 0, 0, 0])


def test_speed_holds_for_one_motion_always_for_the_rest() -> None:
    taken = motions("SPEED 40 ALWAYS\nMOVE p\nSPEED 10\nMOVE p\nMOVE p\nSPEED 50 MONITOR\nMOVE p", motion_ticks=3)
    assert [m.speed for m in taken] == pytest.approx([0.4, 0.1, 0.4, 0.2])


def test_speed_in_mmps_is_that_of_straight_lines() -> None:
    taken = motions(
        "SPEED 60 ALWAYS\nSPEED 250 MMPS ALWAYS\nMOVES p\nMOVE p\nSPEED 50 MONITOR\nMOVES p\nSPEED 80\nMOVES p"
    )
    assert [m.speed_mps for m in taken] == [0.25, None, 0.125, None]
    assert [m.speed for m in taken] == pytest.approx([0.6, 0.6, 0.3, 0.4])


def test_settings_of_motions() -> None:
    source = """ACCEL 30
LEFTY
BELOW
COARSE
MOVE p
FLIP
CP OFF
MOVE p
RIGHTY
ABOVE
NOFLIP
COARSE ALWAYS
CP ON
MOVE p
FINE
MOVE p
MOVE p"""
    a, b, c, d, e = motions(source)
    assert a.acceleration == pytest.approx(0.3)
    assert a.configuration == Configuration("lefty", "below", None)
    assert b.configuration == Configuration("lefty", "below", "flip")
    assert c.configuration == Configuration("righty", "above", "noflip")
    assert [m.blend for m in (a, b, c)] == [True, False, True]
    assert [m.tolerance for m in (a, b, c, d, e)] == ["coarse", "fine", "coarse", "fine", "coarse"]


def test_tool_and_base_place_the_program_in_the_world() -> None:
    source = """TOOL TRANS(0, 0, 20)
BASE TRANS(1000):RZ(90)
MOVE TRANS(300, 0, 100, 0, 180, 0)
HERE h
TYPE /F0.1, DX(h), " ", DY(h), " ", DZ(h)
SET d = DEST
DEPART 10
SET e = DEST
TYPE /F0.1, DISTANCE(d, e), " ", DZ(e)
TOOL
BASE
SET f = HERE
TYPE /F0.1, DX(f), " ", DZ(f)
"""
    machine, _ = run(source)
    assert machine.motions[0].pose[:3, 3] == pytest.approx([1.0, 0.3, 0.12])
    assert [text for text, _ in machine.said] == ["300.0 0.0 100.0", "10.0 110.0", "1000.0 130.0"]


def test_parts_are_located_in_the_frame_of_the_program() -> None:
    machine = FakeMachine(parts=[Part("coin", T, (1.0,))])
    run('BASE TRANS(100, 0, 0, 30)\nTOOL TRANS(0, 0, 5)\nVPICTURE\nVLOCATE "", p\nTOOL\nMOVE p', machine)
    assert machine.motions[0].pose == pytest.approx(T)


def test_here_is_commanded_and_where_is_measured() -> None:
    """The machine measures x = 7 m, and joints 0.01 rad below the commanded ones, moving or not."""
    source = "MOVE TRANS(100)\nHERE a\nWHERE b\nSET c = WHERE\nBREAK\nSET d = HERE\nSET e = WHERE"
    machine, _ = run(source + '\nTYPE DX(a)," ",DX(b)," ",DX(c)," ",DX(d)," ",DX(e)', FakeMachine(motion_ticks=5))
    assert machine.said == [("100 7000 7000 100 7000", 9)]
    source = "MOVE #PPOINT(10, 0, 0, 0, 0, 0)\nHERE #a\nWHERE #b\nSET #c = HERE\nSET #d = WHERE\n"
    machine, _ = run(source + "MOVE #a\nMOVE #b\nMOVE #c\nMOVE #d", FakeMachine(sag=0.01))
    assert [float(m.joints[0]) for m in machine.motions] == pytest.approx(
        np.radians(10) - np.array([0, 0, 0.01, 0, 0.01])
    )


def test_small_steps_do_not_drift() -> None:
    """DRIVE there and back twenty times; the arm stands 0.01 rad below what it is told: it ends where it began."""
    machine, _ = run("FOR i = 1 TO 20\nDRIVE 2, 2, 50\nDRIVE 2, -2, 50\nEND", FakeMachine(sag=0.01, motion_ticks=1))
    assert len(machine.motions) == 40
    assert np.abs(machine.motions[-1].joints).max() < 1e-12


def test_joints_that_slide_are_told_in_mm() -> None:
    """Joint 3 slides: 250 mm are 0.25 m, wherever a program says so; the others turn."""
    turns = tuple(k != 2 for k in range(6))
    locations = read_locations("#a = 90, 0, 250, 0, 0, 0", "x.loc", turns)
    assert locations["#a"] == pytest.approx([np.pi / 2, 0, 0.25, 0, 0, 0])
    source = "MOVE #a\nMOVE #PPOINT(0, 0, 100, 0, 0, 180)\nDRIVE 3, -40, 50\nDRIVE 1, 90, 50\nHERE #b\nMOVE #b"
    program = compile_program(f".PROGRAM m()\n{source}\n.END", "x.arps", locations)
    joints = [m.joints for m in run(program, FakeMachine(slides=(2,)))[0].motions]
    assert joints[1] == pytest.approx([0, 0, 0.1, 0, 0, np.pi])
    assert joints[2] == pytest.approx([0, 0, 0.06, 0, 0, np.pi])
    assert [*joints[3]] == [*joints[4]] == pytest.approx([np.pi / 2, 0, 0.06, 0, 0, np.pi])


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("SPEED 0\nMOVE p", "SPEED is 0; it takes more than 0 and at most 100"),
        ("SPEED 101\nMOVE p", "SPEED is 101"),
        ("SPEED -5 MMPS\nMOVE p", "SPEED -5 MMPS; it must be more than 0"),
        ("SPEED 200 MONITOR", "SPEED MONITOR is 200"),
        ("ACCEL 0", "ACCEL is 0"),
        ("DRIVE 7, 10, 50", "no joint 7; this arm has joints 1 to 6"),
        ("DRIVE 1, 10, 0", "the speed of DRIVE is 0"),
        ("MOVE #PPOINT(1, 2)", "#PPOINT: 2 joint values came; this arm has 6 joints"),
        ("DELAY -1", "DELAY of -1 s"),
        ("MOVE TRANS(20000)", r":3: MOVE: out of reach\n  3 \| MOVE TRANS\(20000\)"),
    ],
)
def test_motion_fault(source: str, message: str) -> None:
    with pytest.raises(ProgramFault, match=message):
        motions(source)


def test_fault_halts_the_program() -> None:
    program = compile_program(".PROGRAM m()\nMOVE TRANS(20000)\n.END")
    state, machine = start(program), FakeMachine()
    with pytest.raises(ProgramFault):
        step(program, state, machine)
    assert step(program, state, machine) == "halted"
    assert machine.motions == []
