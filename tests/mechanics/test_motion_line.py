from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motion_arms import Gantry, GantryWrist, Scara, Solutions, limits_of, pose, rot_z
from scipy.spatial.transform import Rotation, Slerp

from holonom.errors import MotionError, NotAPose, ShapeError
from holonom.mechanics import load_arm
from holonom.mechanics.motion import Trajectory, plan_line

SPEEDS = {"speed": 0.4, "rotation_speed": 2.0, "acceleration": 2.0, "rotation_acceleration": 10.0}
wrist_arm = GantryWrist(limits_of(6))
# Both middle angles on one side of the singular pose, and the line between them too: small turns.
wrist_start = arrays(np.float64, 6, elements=st.floats(-0.5, 0.5)).map(
    lambda q: q + np.array([0, 0, 0, 3.0, 1.5, -3.0])
)


def excess(motion: Trajectory, arm: Gantry | GantryWrist | Scara) -> float:
    limits = arm.limits
    return float(max(np.max(np.abs(motion.qd) / limits.speed), np.max(np.abs(motion.qdd) / limits.acceleration)))


def check_derivatives(motion: Trajectory) -> None:
    """`qd` and `qdd` against central differences; their error is the next derivative's change in a sample."""
    dt = motion.dt
    step = np.abs(np.diff(motion.qdd, axis=0)).max()
    speed = (motion.q[2:] - motion.q[:-2]) / (2 * dt)
    np.testing.assert_allclose(motion.qd[1:-1], speed, atol=0.5 * step * dt)
    acceleration = (motion.qd[2:] - motion.qd[:-2]) / (2 * dt)
    np.testing.assert_allclose(motion.qdd[1:-1], acceleration, atol=0.6 * step)


@settings(max_examples=40, deadline=None)
@given(wrist_start, wrist_start, st.sampled_from(["scurve", "quintic"]))
def test_the_tool_goes_straight_and_turns_as_slerp_within_all_limits(
    q0: np.ndarray, q1: np.ndarray, profile: str
) -> None:
    T0, T1 = wrist_arm.fk(q0), wrist_arm.fk(q1)
    motion = plan_line(wrist_arm, q0, T1, **SPEEDS, profile=profile, line=3)
    np.testing.assert_array_equal(motion.q[0], q0)
    np.testing.assert_allclose(motion.q[-1], q1, atol=1e-9)
    assert not motion.qd[[0, -1]].any()
    assert not motion.qdd[[0, -1]].any()
    assert excess(motion, wrist_arm) <= 1.0
    if len(motion.q) < 20:
        return
    check_derivatives(motion)
    T = wrist_arm.fk(motion.q)
    way, done = T1[:3, 3] - T0[:3, 3], T[:, :3, 3] - T0[:3, 3]
    rotations = Rotation.from_matrix(np.stack([T0[:3, :3], T1[:3, :3]]))
    angle = (rotations[0].inv() * rotations[1]).magnitude()
    turned = (rotations[0].inv() * Rotation.from_matrix(T[:, :3, :3])).magnitude()
    s = done @ way / (way @ way) if angle < 1e-6 or way @ way > 1e-6 else turned / angle
    assert (np.diff(s) >= -1e-12).all()
    np.testing.assert_allclose(done, s[:, None] * way, atol=1e-9)
    np.testing.assert_allclose(T[:, :3, :3], Slerp([0, 1], rotations)(np.clip(s, 0, 1)).as_matrix(), atol=1e-6)
    twist = (wrist_arm.jacobian(motion.q, frame="world") @ motion.qd[..., None])[..., 0]
    speed, turn = np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1)
    assert speed.max() <= 0.4 * (1 + 1e-8)
    assert turn.max() <= 2.0 * (1 + 1e-8)
    assert np.abs(np.diff(speed)).max() / motion.dt <= 2.0 * (1 + 1e-3)
    assert np.abs(np.diff(turn)).max() / motion.dt <= 10.0 * (1 + 1e-3)


@pytest.mark.parametrize("turn", [1e-9, 1e-4, np.pi - 1e-7, np.pi])
def test_slerp_is_well_conditioned_near_zero_and_half_a_turn(turn: float) -> None:
    q0 = np.array([0.0, 0.0, 0.0, 0.3, 1.2, -0.4])
    T0 = wrist_arm.fk(q0)
    T1 = pose(rot_z(np.array(turn)) @ T0[:3, :3], T0[:3, 3] + [0.1, 0.0, 0.0])
    motion = plan_line(wrist_arm, q0, T1, **SPEEDS)
    np.testing.assert_allclose(wrist_arm.fk(motion.q[-1]), T1, atol=1e-9)
    # A turn about z moves the first wrist axis only, by `turn`, in whatever sense half a turn goes.
    assert abs(motion.q[-1, 3] - q0[3]) == pytest.approx(turn, abs=1e-6)
    np.testing.assert_allclose(motion.q[:, 4:], np.broadcast_to(q0[4:], motion.q[:, 4:].shape), atol=1e-6)


def test_joints_pass_the_wrap_of_the_inverse_without_a_jump() -> None:
    q0 = np.array([0.0, 0.0, 0.0, 3.0, 1.0, 9.3])
    q1 = np.array([0.1, 0.1, 0.0, 3.5, 1.0, 9.7])
    motion = plan_line(wrist_arm, q0, wrist_arm.fk(q1), **SPEEDS)
    np.testing.assert_allclose(motion.q[-1], q1, atol=1e-9)
    assert np.abs(np.diff(motion.q, axis=0)).max() < 0.01


@pytest.mark.parametrize("elbow", [1.2, -1.2])
def test_an_arm_of_four_joints_stays_on_its_branch(elbow: float) -> None:
    arm = Scara(limits_of(4))
    q0, q1 = np.array([0.2, elbow, 0.0, 0.3]), np.array([0.9, 0.8 * elbow, 0.1, -0.4])
    motion = plan_line(arm, q0, arm.fk(q1), **SPEEDS)
    np.testing.assert_allclose(motion.q[-1], q1, atol=1e-9)
    check_derivatives(motion)


def test_fast_lines_are_slowed_until_the_joints_keep_their_limits() -> None:
    arm = Scara(limits_of(4, speed=0.5, acceleration=3.0))
    q0 = np.array([0.2, 1.2, 0.0, 0.3])
    T1 = arm.fk(np.array([0.9, 1.0, 0.1, -0.4]))
    motion = plan_line(arm, q0, T1, **SPEEDS)
    free = plan_line(Scara(limits_of(4, speed=50, acceleration=900)), q0, T1, **SPEEDS)
    assert 0.97 < excess(motion, arm) <= 1.0
    assert motion.duration > 1.5 * free.duration
    given = plan_line(Scara(limits_of(4, speed=50, acceleration=900)), q0, T1, **SPEEDS, limits=arm.limits)
    np.testing.assert_array_equal(given.q, motion.q)


def test_a_line_of_no_length_is_one_sample() -> None:
    q0 = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    motion = plan_line(wrist_arm, q0, wrist_arm.fk(q0), **SPEEDS)
    np.testing.assert_array_equal(motion.q, q0[None])


def test_out_of_reach_says_where() -> None:
    arm = Scara(limits_of(4))
    q0 = np.array([0.0, 1.0, 0.0, -1.0])
    T1 = pose(np.eye(3), np.array([0.8, 0.0, 0.0]))
    with pytest.raises(MotionError, match=r"at \d+ % of the straight line, tool at .* out of the arm's reach"):
        plan_line(arm, q0, T1, **SPEEDS)


def test_a_line_through_the_hole_in_the_middle_is_out_of_reach() -> None:
    arm = Scara(limits_of(4))
    q0 = np.array([0.0, 1.0, 0.0, -1.0])
    p = arm.fk(q0)[:3, 3]
    with pytest.raises(MotionError, match="out of the arm's reach"):
        plan_line(arm, q0, pose(np.eye(3), p * [-1.0, -1.0, 1.0]), **SPEEDS)


def test_a_joint_limit_on_the_way_is_named() -> None:
    arm = Gantry(replace(limits_of(3), upper=np.array([1.0, 0.05, 1.0])))
    T1 = pose(np.eye(3), np.array([0.2, 0.1, 0.0]))
    with pytest.raises(MotionError, match=r"at 50 % .* joint 2 would go to 0\.05\d* m; its limits are -10 to 0\.05"):
        plan_line(arm, [0.0, 0.0, 0.0], T1, **SPEEDS)


def test_a_line_through_a_singular_pose_is_driven_where_no_joint_jumps() -> None:
    """The tool tilts through the straight wrist about one axis: joint 5 alone turns, by the law of the line."""
    q0 = np.array([0.0, 0.0, 0.0, 0.3, 0.4, 0.0])
    through = np.array([0.1, 0.0, 0.0, 0.3, -0.4, 0.0])
    driven = plan_line(wrist_arm, q0, wrist_arm.fk(through), **SPEEDS)
    share = driven.q[:, 0] / 0.1
    np.testing.assert_allclose(driven.q, q0 + share[:, None] * (through - q0), atol=1e-6)
    assert np.abs(driven.qdd).max() < 1.1 * np.abs(driven.qdd[:, [0, 4]]).max()
    on_it = q0 + share[:, None] * (through - q0)
    np.testing.assert_allclose(wrist_arm.fk(driven.q), wrist_arm.fk(on_it), atol=1e-9)


def test_a_line_beside_a_singular_pose_would_be_too_slow() -> None:
    q0 = np.array([0.0, 0.0, 0.0, 0.0, 0.4, 0.0])
    beside = pose(Rotation.from_euler("xy", [1e-4, -0.4]).as_matrix(), np.array([0.1, 0.0, 0.0]))
    with pytest.raises(MotionError, match=r"at 5\d % .*joint [46] would (jump|have to be slowed)"):
        plan_line(wrist_arm, q0, beside, **SPEEDS)


@pytest.mark.parametrize("tilt", [0.4, -0.4])
def test_a_singular_start_is_left_where_no_joint_jumps(tilt: float) -> None:
    q0 = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.2])
    q1 = np.array([0.1, 0.0, 0.0, 0.3, tilt, 0.2])
    driven = plan_line(wrist_arm, q0, wrist_arm.fk(q1), **SPEEDS)
    share = driven.q[:, 0] / 0.1
    np.testing.assert_allclose(driven.q, q0 + share[:, None] * (q1 - q0), atol=1e-6)


def test_a_singular_start_that_joint_4_would_have_to_jump_from_is_refused() -> None:
    """The tool is to tilt about another axis than joint 5 has: joints 4 and 6 would turn before anything else moves."""
    q0 = np.array([0.0, 0.0, 0.0, 0.3, 0.0, 0.2])
    with pytest.raises(MotionError, match=r"joint [46] would (jump|have to be slowed)"):
        plan_line(wrist_arm, q0, wrist_arm.fk(np.array([0.1, 0.0, 0.0, 1.3, 0.4, -0.8])), **SPEEDS)


class Swapping(GantryWrist):
    """Loses the order of its branches halfway."""

    def ik(self, T: np.ndarray, q0: np.ndarray) -> Solutions:
        solutions = super().ik(T, q0)
        half = len(T) // 2
        return Solutions(np.concatenate([solutions.q[:half], solutions.q[half:, ::-1]]), solutions.status)


def test_branches_are_followed_by_continuity_not_by_their_order() -> None:
    q0 = np.array([0.0, 0.0, 0.0, 0.3, 0.5, 0.2])
    arms = (Swapping(limits_of(6)), wrist_arm)
    driven, expected = (plan_line(arm, q0, wrist_arm.fk(q0 + 0.1), **SPEEDS) for arm in arms)
    np.testing.assert_allclose(driven.q, expected.q, atol=1e-12)


def test_a_motion_that_the_arm_has_no_joint_for_is_refused() -> None:
    T1 = pose(Rotation.from_euler("x", 0.3).as_matrix(), np.array([0.4, 0.3, 0.0]))
    with pytest.raises(MotionError, match="4 joints cannot follow"):
        plan_line(Scara(limits_of(4)), [0.1, 1.0, 0.0, 0.0], T1, **SPEEDS)


@pytest.mark.parametrize(
    "goal", [np.stack(2 * [np.eye(4)]), np.eye(3), 2 * np.eye(4), np.diag([1.0, 1, -1, 1]), np.full((4, 4), np.nan)]
)
def test_a_goal_has_to_be_a_pose(goal: np.ndarray) -> None:
    with pytest.raises(NotAPose, match="goal"):
        plan_line(wrist_arm, np.zeros(6), goal, **SPEEDS)


def test_a_start_has_to_fit_the_arm() -> None:
    with pytest.raises(ShapeError, match="the arm has 6 joints"):
        plan_line(wrist_arm, np.zeros(5), np.eye(4), **SPEEDS)


@pytest.mark.parametrize("way", [(0.04, 0.0, 0.0), (0.0, 0.0, 0.04), (-0.03, 0.0, -0.03)])
@pytest.mark.parametrize(("shoulder", "elbow"), [(-100, 70), (-100, 50), (-80, 50), (-60, 90)])
def test_a_line_on_which_a_ur_stays_singular_is_driven(shoulder: float, elbow: float, way: tuple[float, ...]) -> None:
    """At q5 = 0 joint 6 is parallel to joints 2 to 4: in their plane the arm has a joint to spare; none jumps."""
    arm = load_arm("ur5e").with_limits(accelerations=20.0)
    q0 = np.radians([0.0, shoulder, elbow, -50 - shoulder - elbow, 0.0, 0.0])
    goal = arm.fk(q0)
    goal[:3, 3] += way
    driven = plan_line(arm, q0, goal, speed=0.1, acceleration=1.0, rotation_speed=1.0, rotation_acceleration=5.0)
    T = arm.fk(driven.q)
    np.testing.assert_allclose(T[-1], goal, atol=1e-8)
    along = (T[:, :3, 3] - T[0, :3, 3]) @ way / np.linalg.norm(way)
    np.testing.assert_allclose(T[:, :3, 3] - T[0, :3, 3], along[:, None] * way / np.linalg.norm(way), atol=1e-8)
    assert np.abs(np.diff(driven.q, axis=0)).max() < 2e-3  # at 0.1 m/s and 1 ms
    assert np.abs(driven.q[:, [0, 4]] - q0[[0, 4]]).max() < 1e-6
