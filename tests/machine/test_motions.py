"""From a motion of a program to joints: lines through singular wrists, configurations that are kept, time limits."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from holonom import load_arm
from holonom.errors import MotionError
from holonom.lang import Configuration, Motion, compile_program, poses, start, step
from holonom.machine import DryMachine, LineSettings
from holonom.machine.arm import dry
from holonom.machine.arm.motions import branch_joints, plan
from holonom.mechanics.motion import ArcAbout, LineTo, plan_line, plan_path

PUMA = load_arm("puma560")
HOME = np.radians([0.0, 45.0, -180.0, 0.0, -45.0, 0.0])
LINE = LineSettings()
TOOL = {"speed": 0.25, "rotation_speed": 1.0, "acceleration": 1.0, "rotation_acceleration": 4.0}
DOWN = poses.transformation((350, -150, 420, 0, 180, 0))


def request(kind: str, pose: np.ndarray, speed: float = 1.0, **configuration: str) -> Motion:
    return Motion(kind, pose, None, speed, None, 1.0, Configuration(**configuration), False, "fine", 1)


def above(T: np.ndarray, height: float = 0.05) -> np.ndarray:
    raised = T.copy()
    raised[2, 3] += height
    return raised


@cache
def over_down() -> np.ndarray:
    """Joints 50 mm above `DOWN`, where a program comes from home."""
    return plan(PUMA, HOME, request("joint", above(DOWN)), LINE).end


def test_the_wrist_passes_through_its_straight_pose_on_a_line() -> None:
    """Joint 5 changes its sign in the plane of the arm: joints 4 and 6 stand still, and nothing jumps."""
    driven = plan(PUMA, over_down(), request("line", DOWN), LINE)
    q5 = driven.q[:, 4]
    assert q5[0] < 0.0 < q5[-1]
    assert np.abs(np.diff(driven.q, axis=0)).max() < np.radians(0.05)
    assert np.ptp(driven.q[:, [0, 3, 5]], axis=0).max() < 1e-9
    T = PUMA.fk(driven.q)
    np.testing.assert_allclose(T[:, :2, 3], np.broadcast_to(DOWN[:2, 3], (len(T), 2)), atol=1e-9)
    np.testing.assert_allclose(T[:, :3, :3], np.broadcast_to(DOWN[:3, :3], (len(T), 3, 3)), atol=1e-9)


def test_no_approach_of_a_raster_is_refused_falsely() -> None:
    """Wherever both ends can be reached without a swing of a joint, the line between them is driven."""
    tried = 0
    for x, y in itertools.product(range(200, 851, 50), range(-600, 601, 50)):
        T = poses.transformation((x, y, 420, 0, 180, 0))
        try:
            q = branch_joints(PUMA, above(T), HOME, Configuration())
            branch_joints(PUMA, T, q, Configuration())
        except MotionError:
            continue
        driven = plan(PUMA, q, request("line", T), LINE, 5e-3)
        assert np.abs(np.diff(driven.q, axis=0)).max() < 0.02, (x, y)
        assert np.abs(PUMA.fk(driven.q)[:, :2, 3] - T[:2, 3]).max() < 1e-9, (x, y)
        tried += 1
    assert tried > 220


@pytest.mark.parametrize("name", ["puma560", "ur5e", "stanford"])
def test_a_line_through_a_singular_wrist_steps_no_more_than_its_tangent(name: str) -> None:
    """Lines whose tangent at q5 = 0 the joints can follow: driven, on the line, with the slope of that tangent."""
    arm, rng, driven = load_arm(name), np.random.default_rng(5), 0
    refused: list[str] = []
    lower, upper = np.maximum(arm.limits.lower, -2.5) + 0.3, np.minimum(arm.limits.upper, 2.5) - 0.3
    bounds = type(arm.limits)(
        arm.limits.names, arm.limits.lower, arm.limits.upper, np.full(6, 5.0), np.full(6, 60.0), arm.limits.torque,
        arm.limits.turns,
    )  # fmt: skip
    for _ in range(12):
        q = rng.uniform(lower, upper)
        q[4] = 0.0
        rate = rng.uniform(-0.1, 0.1, 6)
        rate[4] = 0.1
        start_, goal = (_along(arm, q, s * rate) for s in (-1.0, 1.0))
        q0 = _followed(arm, q, rate)
        if q0 is None or np.abs(arm.fk(q0) - start_).max() > 1e-8:
            continue
        try:
            line = plan_line(arm, q0, goal, **TOOL, limits=bounds, dt=4e-3)
        except MotionError as problem:
            refused.append(str(problem))
            continue
        middle = int(np.argmin(np.abs(line.q[:, 4])))
        assert np.abs(line.q[middle] - q).max() < 2e-3, "through the singular joints themselves"
        assert np.abs(np.diff(line.q, axis=0)).max() < 0.01
        driven += 1
    assert driven >= 6
    assert all("out of the arm's reach" in text or "would go to" in text for text in refused)


def _along(arm, q: np.ndarray, rate: np.ndarray) -> np.ndarray:  # type: ignore[no-untyped-def]
    """The pose reached from fk(q) by the twist J(q) rate, place and turn apart, as a straight line of the tool does."""
    V, T = arm.jacobian(q) @ rate, arm.fk(q)
    T[:3, 3] += V[:3]
    T[:3, :3] = Rotation.from_rotvec(V[3:]).as_matrix() @ T[:3, :3]
    return T


def _followed(arm, q: np.ndarray, rate: np.ndarray) -> np.ndarray | None:  # type: ignore[no-untyped-def]
    """Joints at the start of the line by Newton's method from its middle backwards: independent of the planner."""
    now = q
    for s in np.linspace(0.0, -1.0, 21)[1:]:
        goal = _along(arm, q, s * rate)
        for _ in range(12):
            T = arm.fk(now)
            turn = Rotation.from_matrix(goal[:3, :3] @ T[:3, :3].T).as_rotvec()
            now = now + np.linalg.pinv(arm.jacobian(now), rcond=1e-6) @ np.r_[goal[:3, 3] - T[:3, 3], turn]
    return now if np.abs(now - q).max() < 0.5 else None


def test_arcs_and_blends_pass_through_it_too() -> None:
    """Down through the straight wrist on a line, an arc in the arm's plane, and flown by between them."""
    q0, T0 = over_down(), above(DOWN)
    side = np.array([T0[1, 3], -T0[0, 3], 0.0]) / np.hypot(
        *T0[:2, 3]
    )  # at right angles to the plane through the axis of joint 1
    out = np.array([T0[0, 3], T0[1, 3], 0.0]) / np.hypot(*T0[:2, 3])
    arc = ArcAbout(T0[:3, 3] - 0.05 * out, side, -0.8, turn_tool=False)
    for segments in ([arc], [LineTo(DOWN), LineTo(above(DOWN, 0.02))], [arc, LineTo(DOWN)]):
        path = plan_path(PUMA, q0, segments, **TOOL)
        assert np.abs(np.diff(path.q, axis=0)).max() < 5e-3
        assert path.q[:, 4].min() < 0.0 < path.q[:, 4].max()


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"shoulder": "lefty"}, "LEFTY was asked for, and the arm is righty above flip"),
        ({"elbow": "below"}, "BELOW was asked for, and the arm is righty above flip"),
        ({"wrist": "flip"}, "FLIP was asked for, and the arm would end righty above noflip"),
    ],
)
def test_a_line_does_not_change_the_configuration_without_a_word(asked: dict[str, str], words: str) -> None:
    with pytest.raises(MotionError, match=f"a straight line cannot change the configuration: {words}"):
        plan(PUMA, over_down(), request("line", DOWN, **asked), LINE)


def test_what_is_asked_for_and_so_is_driven() -> None:
    driven = plan(PUMA, over_down(), request("line", DOWN, shoulder="righty", elbow="above"), LINE)
    on = plan(PUMA, driven.end, request("joint", above(DOWN, 0.01)), LINE)
    assert np.abs(on.end - driven.end).max() < 0.05, "the next motion does not swing over"


def test_a_check_tells_the_line_that_cannot_change_it() -> None:
    machine = dry_machine()
    run("READY\nLEFTY\nDRAW 0, 0, 10\nMOVE TRANS(400,-150,450,0,180,0)\nDRAW 0, 0, 10", machine)
    (problem,) = machine.problems
    assert (problem.line, "LEFTY was asked for" in problem.text) == (4, True)


@pytest.mark.parametrize("name", ["puma560", "ur5e", "stanford"])
def test_a_named_configuration_goes_to_its_nearest_member(name: str) -> None:
    """At the straight wrist a configuration is a set: the joints that the arm has are in it, and are kept."""
    arm, rng = load_arm(name), np.random.default_rng(3)
    lower, upper = np.maximum(arm.limits.lower, -2.5) + 0.1, np.minimum(arm.limits.upper, 2.5) - 0.1
    parts = {"righty": "shoulder", "lefty": "shoulder", "above": "elbow", "below": "elbow", "flip": "wrist"}
    for _ in range(10):
        q = rng.uniform(lower, upper)
        q[4] = 0.0
        nearest = arm.ik_nearest(arm.fk(q), q)
        words = nearest.names[int(nearest.branch)].split()
        asked = Configuration(**{parts[word]: word for word in words if word in parts})
        np.testing.assert_allclose(branch_joints(arm, arm.fk(q), q, asked), q, atol=1e-6)


def test_an_arm_without_a_closed_form_says_so_in_a_programs_words() -> None:
    panda = load_arm("panda")
    q = np.array(panda.model.poses["ready"])
    T = panda.fk(q)
    np.testing.assert_allclose(branch_joints(panda, T, q, Configuration()), q, atol=1e-6)
    with pytest.raises(MotionError, match="no joints within the limits were found"):
        branch_joints(panda, above(T, 3.0), q, Configuration())
    for kind in ("joint", "line"):
        with pytest.raises(MotionError, match="LEFTY was asked for"):
            plan(panda, q, request(kind, above(T, 0.01), shoulder="lefty"), LINE)


def dry_machine(**options: float) -> DryMachine:
    return DryMachine(PUMA, HOME, look=lambda: (), ready=HOME, line=LINE, hand_time=0.1, **options)


def run(body: str, machine: DryMachine) -> None:
    program = compile_program(f".PROGRAM m()\n{body}\n.END\n")
    state = start(program)
    while step(program, state, machine) not in ("halted", "paused"):
        machine.tick()


@pytest.mark.parametrize("kind", ["joint", "line"])
@pytest.mark.parametrize("percent", [1e-3, 1e-12])
def test_a_motion_that_takes_longer_than_allowed_is_refused_with_its_duration(kind: str, percent: float) -> None:
    """Time is way over speed, and a little for the ramps; nothing is sampled, so no memory is asked for."""
    with pytest.raises(MotionError, match=r"the motion would take \S+ s; up to 120 s are allowed") as caught:
        plan(PUMA, over_down(), request(kind, DOWN, percent / 100), LINE, longest=120.0)
    told = float(str(caught.value).split()[4])
    way = np.abs(branch_joints(PUMA, DOWN, over_down(), Configuration()) - over_down()) / PUMA.limits.speed
    least = way.max() if kind == "joint" else 0.05 / LINE.speed
    assert told == pytest.approx(least / (percent / 100), rel=1e-3)


def test_what_cannot_even_be_numbered_is_refused() -> None:
    with pytest.raises(MotionError, match=r"the motion would last \d\.\d+e\+30\d s"):
        plan(PUMA, HOME, request("joint", DOWN, 1e-303), LINE, longest=120.0)


def test_laps_are_planned_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A thousand laps ask for as many different motions as two: what a check plans does not grow with them."""
    planned = []

    def counting(*given, **options):  # type: ignore[no-untyped-def]
        planned.append(1)
        return plan(*given, **options)

    monkeypatch.setattr(dry, "plan", counting)
    square = "DRAW 0,100\nDRAW 100\nDRAW 0,-100"
    lap = f"MOVES TRANS(400,-100,500,0,180,0)\n{square}\nMOVE TRANS(400,-100,450,0,180,0)\nDEPARTS 20"
    machine = dry_machine()
    run(f"FOR i = 1 TO 1000\n{lap}\nEND", machine)
    assert machine.moved == 6000
    assert len(planned) < 40
    assert machine.problems == []
