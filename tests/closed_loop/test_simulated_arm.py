"""The machines: both satisfy `lang.Machine`; the simulated one queues, blends, settles and stops."""

from __future__ import annotations

import numpy as np
import pytest
from demo_cell import (
    ARM,
    HOME,
    ListSink,
    make_arm,
    make_disc,
    make_dry,
    make_hand,
    motion,
    run_dry,
    run_simulated,
    tool_down,
)

from holonom.errors import DriveFault, MotionError
from holonom.lang import Machine, Motion, Part, compile_program
from holonom.machine import ArmMachine
from holonom.signals import (
    DriveState,
    DriveTruth,
    EncoderCounts,
    Event,
    FramePoses,
    JointCommand,
    JointState,
    JointTruth,
    Signal,
)

SMALL = HOME + np.array([0.3, -0.1, 0.1, 0.0, 0.1, 0.2])
OTHER = HOME + np.array([-0.2, 0.1, -0.1, 0.1, 0.0, 0.0])

PROGRAM = """
.PROGRAM main()
  SPEED 80 ALWAYS
  VPICTURE
  VLOCATE "coin", coin
  APPRO coin, 60
  MOVES coin
  CLOSEI
  DEPARTS 60
  SIGNAL 3
  MOVE SHIFT(coin BY 0, 150, 30)
  DRAW 20, 0, -10
  DRIVE 6, 15, 50
  OPENI
  IF SIG(3) THEN
    TYPE "done"
  END
.END
"""


def test_both_machines_run_the_same_program_to_the_same_joints() -> None:
    part = Part("coin", tool_down(0.55, -0.1, 0.301), (1.0, 0.55, -0.1, 0.0, 3e-4, 0.02))
    hand = make_hand([make_disc(0.55, -0.1)])
    arm, sink = make_arm(hand, [part])
    simulated = arm.machine
    dry = make_dry([part])
    machines: list[Machine] = [simulated, dry]
    program = compile_program(PROGRAM)
    run_simulated(program, simulated)
    run_dry(program, dry)
    assert dry.problems == []
    assert dry.moved == 6
    assert dry.typed == ["done"]
    goal = [machine.destination() for machine in machines]
    np.testing.assert_allclose(goal[0], goal[1], atol=1e-9)
    np.testing.assert_allclose(simulated.joints(), dry.joints(), atol=6e-4)
    assert all(machine.signal(3) and not machine.signal(4) for machine in machines)
    assert all(machine.idle() and machine.hand_idle() for machine in machines)
    assert next(event.text for event in sink.of(Event) if event.source == "hand") == "grasped coin_01"
    assert hand.world.discs[0].pose[1, 3] == pytest.approx(0.05, abs=2e-3), "it was carried by 150 mm"


def advance(machine: ArmMachine, ticks: int = 2000) -> int:
    """Until the arm is at rest; the ticks it took."""
    for tick in range(ticks):
        if machine.idle():
            return tick
        machine.advance()
    raise AssertionError("it does not settle")


def test_a_motion_is_taken_made_and_settled() -> None:
    arm, _ = make_arm()
    machine = arm.machine
    assert machine.idle()
    assert machine.move(motion(SMALL, line=7))
    assert not machine.idle()
    assert machine.active_line == 7
    np.testing.assert_array_equal(machine.destination(), ARM.fk(SMALL))
    advance(machine)
    assert machine.active_line == 0
    np.testing.assert_allclose(machine.joints(), SMALL, atol=2e-4)
    np.testing.assert_allclose(machine.pose(), ARM.fk(SMALL), atol=6e-4)


def test_one_motion_waits_behind_the_one_under_way() -> None:
    arm, _ = make_arm()
    machine = arm.machine
    assert machine.move(motion(SMALL, line=1))
    assert machine.move(motion(OTHER, line=2)), "the first may be blended into"
    assert not machine.move(motion(HOME, line=3)), "the second has not begun"
    lines = []
    while not machine.move(motion(HOME, line=3)):
        lines.append(machine.active_line)
        machine.advance()
    assert lines == sorted(lines)
    assert set(lines) == {1}, "the third is taken as soon as the second has begun"
    assert machine.active_line == 2


def via_speed(*, blend: bool) -> tuple[float, float]:
    """Least joint speed on the way between two motions in the same direction, and the time for both."""
    arm, sink = make_arm()
    machine = arm.machine
    goal, ticks = 2 * SMALL - HOME, 0
    assert machine.move(motion(SMALL, blend=blend))
    taken = False
    while not (taken and machine.idle()):
        taken = taken or machine.move(motion(goal, blend=blend))
        machine.advance()
        ticks += 1
    speed = np.abs(np.array([state.velocity for state in sink.of(JointState)])[:, 0])
    moving = np.flatnonzero(speed > 0.3)
    return float(speed[moving[0] : moving[-1]].min()), 0.01 * ticks


def test_continuous_path_does_not_stop_between_motions() -> None:
    slowest, time = via_speed(blend=True)
    stopping, longer = via_speed(blend=False)
    assert stopping < 0.02
    assert slowest > 0.2
    assert time < longer - 0.1


def test_halt_brakes_on_the_path() -> None:
    arm, sink = make_arm()
    machine = arm.machine
    machine.move(motion(SMALL))
    for _ in range(25):
        machine.advance()
    assert np.abs(arm.loop.plant.qd).max() > 0.3
    before = len(sink.of(JointState))
    machine.halt()
    assert np.abs(arm.loop.plant.qd).max() < 0.02
    states = np.array([state.position for state in sink.of(JointState)][before:])
    assert len(states) > 3
    way = (states - HOME) / np.where(SMALL == HOME, np.inf, SMALL - HOME)
    moved = SMALL != HOME
    assert np.ptp(way[:, moved], axis=1).max() < 0.02, "all joints stay in step: on the path"
    assert 0.0 < way[-1, 0] < 1.0
    change = np.abs(np.diff([command.velocity for command in sink.of(JointCommand)], axis=0)).max(0) / 0.01
    assert (change <= 1.01 * ARM.limits.acceleration).all()


def test_a_drive_fault_ends_at_rest() -> None:
    """The hand suddenly holds more than the drives can carry; once it has let go, they hold zero speed."""
    arm, _ = make_arm()
    machine = arm.machine
    machine.move(motion(SMALL, line=5))
    for _ in range(25):
        machine.advance()
    arm.loop.plant.payload = np.array([500.0, 0.0, 0.0, 0.0])
    rest = machine.queue.take(10)[:, -1:].repeat(300, axis=1)
    with pytest.raises(DriveFault):
        arm.loop.advance(rest)
    assert machine.active_line == 5
    arm.loop.plant.payload = np.zeros(4)
    machine.brake()
    assert np.abs(arm.loop.plant.qd).max() < 0.02
    assert machine.idle()


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        (motion(tool_down(2.0, 0.0, 0.3)), r"cannot reach \(2000.0, 0.0, 300.0\) mm: out of reach"),
        (motion(tool_down(2.0, 0.0, 0.3), kind="line"), "out of the arm's reach"),
        (motion(HOME + 3.0), r"waist is to go to 171\.887 deg; its limits are -160 to 160 deg$"),
        (motion(np.zeros(5)), r"has shape \(5,\); the arm has 6 joints"),
        (motion(np.zeros(5), kind="line"), r"\(5,\)"),
    ],
)
def test_what_cannot_be_made_is_a_motion_error_on_both(wanted: Motion, said: str) -> None:
    arm, _ = make_arm()
    machine = arm.machine
    with pytest.raises(MotionError, match=said):
        machine.move(wanted)
    assert machine.idle()
    dry = make_dry()
    assert dry.move(wanted)
    assert dry.problems[0].line == 1
    np.testing.assert_array_equal(dry.joints(), HOME)


def test_a_line_to_joints_ends_at_their_tool_pose() -> None:
    dry = make_dry()
    assert dry.move(motion(SMALL, kind="line"))
    assert dry.problems == []
    np.testing.assert_allclose(dry.destination(), ARM.fk(SMALL), atol=1e-9)


def test_a_dry_machine_takes_a_motion_a_tick_and_counts_its_time() -> None:
    dry = make_dry()
    assert dry.move(motion(SMALL))
    assert not dry.move(motion(HOME))
    dry.tick()
    once = dry.time()
    arm, _ = make_arm()
    machine = arm.machine
    machine.move(motion(SMALL))
    assert once == pytest.approx(0.01 * len(machine.queue.planned.q) / 10, abs=0.011)
    assert dry.move(motion(SMALL))
    dry.tick()
    assert dry.time() == pytest.approx(once + 0.01), "where it already stands: a tick"


def test_every_tick_is_recorded_once() -> None:
    arm, sink = make_arm(make_hand([make_disc(0.55, -0.1)]))
    machine = arm.machine
    machine.move(motion(SMALL))
    machine.set_signal(2, True)
    machine.set_signal(2, True)
    for _ in range(50):
        machine.advance()
    for kind in (JointState, JointCommand, JointTruth, DriveState, DriveTruth, EncoderCounts, FramePoses):
        times = [record.time for record in sink.of(kind)]
        np.testing.assert_allclose(times, 0.01 * np.arange(51), atol=1e-12)
    assert [(s.time, s.number, s.on) for s in sink.of(Signal)] == [(0.0, 2, True)]
    frames: FramePoses = sink.of(FramePoses)[-1]
    assert frames.names[-1] == "finger_right"
    T = dict(zip(frames.names, frames.poses, strict=True))
    np.testing.assert_array_equal(T["tool"], ARM.fk(arm.loop.plant.q))
    gap = T["finger_left"][:3, 3] - T["finger_right"][:3, 3]
    np.testing.assert_allclose(gap, arm.fingers.opening * T["tool"][:3, 1], atol=1e-12)


def test_a_collision_is_recorded_where_it_happened() -> None:
    hand = make_hand([make_disc(0.55, -0.1)])
    arm, sink = make_arm(hand)
    machine = arm.machine
    machine.move(motion(tool_down(0.55, -0.085, 0.36)))
    advance(machine)
    machine.move(motion(tool_down(0.55, -0.085, 0.301), kind="line", line=4))
    with pytest.raises(MotionError, match="a finger hit coin_01"):
        advance(machine)
    assert machine.active_line == 4
    assert sink.of(JointState)[-1].time == machine.time()
    assert isinstance(sink, ListSink)
    assert machine.pose()[2, 3] < 0.3025
    machine.halt()
    assert np.abs(arm.loop.plant.qd).max() < 0.02


def test_small_steps_under_computed_torque_do_not_drift() -> None:
    """20 times 2 degrees there and back: the arm ends where it began, commanded exactly, measured as it settles."""
    steps = "FOR i = 1 TO 20\nDRIVE 2, 2, 100\nDRIVE 2, -2, 100\nEND\nBREAK"
    again = steps.replace("END", "SET #p = HERE\nMOVE #p\nEND")
    ends = "TYPE /F0.9, DISTANCE(a, b)\nTYPE /F0.9, DISTANCE(c, d)"
    source = f".PROGRAM m()\nHERE a\nWHERE c\n{steps}\n{again}\nHERE b\nWHERE d\n{ends}\n.END\n"
    arm, sink = make_arm()
    run_simulated(compile_program(source), arm.machine, 40.0)
    commanded, measured = (float(event.text) for event in sink.of(Event) if event.source == "program")
    assert commanded < 1e-6
    assert measured < 0.15, "a joint counts as settled within 0.2 mrad, at a reach of 0.7 m"
