from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motion_arms import Gantry, GantryWrist, limits_of, pose, rot_y, rot_z
from scipy.spatial.transform import Rotation, Slerp

from holonom.errors import InputError, MotionError, NotAPose, OutOfLimits, ShapeError
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.motion import ArcAbout, ArcTo, LineTo, SplineTo, Trajectory, plan_line, plan_path

SPEEDS = {"speed": 0.4, "rotation_speed": 2.0, "acceleration": 2.0, "rotation_acceleration": 10.0}
ARM = GantryWrist(limits_of(6, reach=20.0, speed=6.0, acceleration=80.0))
Q0 = np.array([0.0, 0.0, 0.0, 3.0, 1.5, -3.0])
point = arrays(np.float64, 3, elements=st.floats(-0.5, 0.5))
small_turn = arrays(np.float64, 3, elements=st.floats(-0.4, 0.4))


def moved(T: np.ndarray, shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
    return pose(Rotation.from_rotvec(turn).as_matrix() @ T[:3, :3], T[:3, 3] + shift)


def check_tool(motion: Trajectory, arm: GantryWrist = ARM) -> None:
    """Speeds and accelerations of the tool by differences of its poses, and continuity of both parts."""
    T, dt = arm.fk(motion.q), motion.dt
    v = np.diff(T[:, :3, 3], axis=0) / dt
    R = Rotation.from_matrix(T[:, :3, :3])
    w = (R[1:] * R[:-1].inv()).as_rotvec() / dt
    assert np.linalg.norm(v, axis=1).max() <= 0.4 * (1 + 1e-6)
    assert np.linalg.norm(w, axis=1).max() <= 2.0 * (1 + 1e-6)
    assert np.linalg.norm(np.diff(v, axis=0), axis=1).max() / dt <= 2.0 * (1 + 1e-3)
    assert np.linalg.norm(np.diff(w, axis=0), axis=1).max() / dt <= 10.0 * (1 + 1e-3)
    limits = arm.limits
    assert (np.abs(motion.qd) <= limits.speed).all()
    assert (np.abs(motion.qdd) <= limits.acceleration).all()


@settings(max_examples=25)
@given(point, point, small_turn)
def test_an_arc_through_three_places_stays_on_its_circle(via: np.ndarray, end: np.ndarray, turn: np.ndarray) -> None:
    T0 = ARM.fk(Q0)
    a, b = via, end
    area = np.linalg.norm(np.cross(a, b))
    if area < 1e-3:
        return
    radius = np.linalg.norm(a) * np.linalg.norm(b) * np.linalg.norm(b - a) / (2.0 * area)
    if radius > 2.0:
        return
    T1 = moved(T0, end, turn)
    motion = plan_path(ARM, Q0, [ArcTo(via, T1)], **SPEEDS, dt=2e-3)
    T = ARM.fk(motion.q)
    p = T[:, :3, 3]
    normal = np.cross(a, b) / area
    np.testing.assert_allclose(p @ normal, 0.0, atol=1e-9)
    # the circumcentre is as far from all three; every place of the motion is as far from it
    spread = np.linalg.solve(np.array([2 * a, 2 * b, normal]), np.array([a @ a, b @ b, 0.0]))
    np.testing.assert_allclose(np.linalg.norm(p - spread, axis=1), radius, atol=1e-9)
    np.testing.assert_allclose(T[-1], T1, atol=1e-9)
    step = np.linalg.norm(np.diff(p, axis=0), axis=1).max()
    assert np.linalg.norm(p - via, axis=1).min() <= step
    R = Rotation.from_matrix(np.stack([T0[:3, :3], T1[:3, :3]]))
    done = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    np.testing.assert_allclose(T[:, :3, :3], Slerp([0, 1], R)(done / done[-1]).as_matrix(), atol=1e-5)
    check_tool(motion)


@pytest.mark.parametrize("turn_tool", [True, False])
@pytest.mark.parametrize("angle", [2 * np.pi, -1.0, 3 * np.pi])
def test_an_arc_about_an_axis(angle: float, turn_tool: bool) -> None:
    segment = ArcAbout([0.2, 0.1, 0.7], [0.0, 0.0, 3.0], angle, turn_tool=turn_tool)
    motion = plan_path(ARM, Q0, [segment], **SPEEDS)
    T = ARM.fk(motion.q)
    spoke = T[:, :2, 3] - [0.2, 0.1]
    np.testing.assert_allclose(np.linalg.norm(spoke, axis=1), np.hypot(0.2, 0.1), atol=1e-12)
    np.testing.assert_allclose(T[:, 2, 3], 0.0, atol=1e-12)
    turned = np.unwrap(np.arctan2(spoke[:, 1], spoke[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(angle, abs=1e-9)
    R = rot_z(turned - turned[0]) @ T[0, :3, :3] if turn_tool else T[0, :3, :3]
    np.testing.assert_allclose(T[:, :3, :3], np.broadcast_to(R, (len(T), 3, 3)), atol=1e-9)
    check_tool(motion)


@pytest.mark.parametrize("degree", [3, 5])
def test_a_spline_passes_its_poses_smoothly(degree: int) -> None:
    rng = np.random.default_rng(1)
    T0 = ARM.fk(Q0)
    poses = np.array([moved(T0, k * np.array([0.1, 0.02, 0.0]) + rng.uniform(-0.05, 0.05, 3), rng.uniform(-0.3, 0.3, 3))
                      for k in range(1, 6)])  # fmt: skip
    motion = plan_path(ARM, Q0, [SplineTo(poses, degree)], **SPEEDS)
    T = ARM.fk(motion.q)
    for goal in poses:
        k = int(np.argmin(np.linalg.norm(T[:, :3, 3] - goal[:3, 3], axis=1)))
        assert np.linalg.norm(T[k, :3, 3] - goal[:3, 3]) < 0.4 * motion.dt
        assert (Rotation.from_matrix(T[k, :3, :3]).inv() * Rotation.from_matrix(goal[:3, :3])).magnitude() < 2e-3
    np.testing.assert_allclose(T[-1], poses[-1], atol=1e-9)
    check_tool(motion)  # a jump of the angular velocity would pass the acceleration limit there
    middle = 0.5 * (motion.qd[1:] + motion.qd[:-1]) * motion.dt
    np.testing.assert_allclose(np.diff(motion.q, axis=0), middle, atol=1e-6)


def test_segments_in_one_call_with_and_without_fly_by() -> None:
    T0 = ARM.fk(Q0)
    T1 = moved(T0, np.array([0.3, 0.0, 0.0]), np.array([0.0, 0.2, 0.0]))
    T2 = moved(T1, np.array([0.0, 0.2, 0.0]), np.zeros(3))
    segments = [T1, ArcTo([0.4, 0.1, 0.0], T2), LineTo(T0)]
    stopped = plan_path(ARM, Q0, segments, **SPEEDS, blend=False, line=5)
    flown = plan_path(ARM, Q0, segments, **SPEEDS, line=5)
    lengths = [0.3, 0.1 * np.pi, np.hypot(0.3, 0.2)]
    p = ARM.fk(stopped.q)[:, :3, 3]
    assert np.linalg.norm(np.diff(p, axis=0), axis=1).sum() == pytest.approx(sum(lengths), abs=1e-4)
    for goal in (T1, T2, T0):
        assert np.linalg.norm(p - goal[:3, 3], axis=1).min() < 1e-9
    at_via = int(np.argmin(np.linalg.norm(p - T1[:3, 3], axis=1)))
    assert np.abs(stopped.qd[at_via]).max() < 1e-9
    assert flown.duration < stopped.duration - 0.1
    assert flown.line == stopped.line == 5
    np.testing.assert_allclose(flown.q[[0, -1]], stopped.q[[0, -1]], atol=1e-9)
    assert (np.abs(flown.qd) <= ARM.limits.speed).all()
    assert np.abs(np.diff(flown.q, axis=0)).max() / flown.dt <= 6.0
    one = plan_path(ARM, Q0, [T1], **SPEEDS)
    np.testing.assert_array_equal(one.q, plan_line(ARM, Q0, T1, **SPEEDS).q)


@pytest.fixture(scope="module")
def puma() -> Arm:
    return load_arm("puma560")


def test_a_real_arm_draws_a_circle(puma: Arm) -> None:
    q0 = np.array([0.2, 0.7, -3.0, 0.2, -0.9, 0.3])
    center = puma.fk(q0)[:3, 3] + [0.0, 0.1, 0.0]
    motion = plan_path(puma, q0, [ArcAbout(center, [1.0, 0.0, 0.0], 2 * np.pi, turn_tool=False)], **SPEEDS)
    T = puma.fk(motion.q)
    np.testing.assert_allclose(np.linalg.norm(T[:, :3, 3] - center, axis=1), 0.1, atol=1e-9)
    np.testing.assert_allclose(T[:, :3, :3], np.broadcast_to(T[0, :3, :3], (len(T), 3, 3)), atol=1e-9)
    np.testing.assert_allclose(motion.q[-1], q0, atol=1e-9)


class Seven:
    """The wrist arm on a track along x: seven joints, no closed form."""

    limits = limits_of(7, speed=6.0, acceleration=80.0)

    def fk(self, q: np.ndarray) -> np.ndarray:
        q = np.asarray(q)
        return ARM.fk(np.concatenate([q[..., :1] + q[..., 6:], q[..., 1:6]], axis=-1))

    def jacobian(self, q: np.ndarray, *, frame: str) -> np.ndarray:
        J = ARM.jacobian(np.asarray(q)[..., :6], frame=frame)
        return np.concatenate([J, J[..., :1]], axis=-1)

    def ik(self, T: np.ndarray, q0: np.ndarray) -> None:
        raise InputError("no closed form")


def test_an_arm_without_closed_form_is_led_step_by_step() -> None:
    arm, q0 = Seven(), np.concatenate([Q0, [0.0]])
    T1 = moved(arm.fk(q0), np.array([0.2, 0.1, 0.0]), np.array([0.1, 0.2, 0.3]))
    motion = plan_path(arm, q0, [ArcTo([0.1, 0.2, 0.0], T1)], **SPEEDS, dt=4e-3)
    T = arm.fk(motion.q)
    np.testing.assert_allclose(T[-1], T1, atol=1e-9)
    np.testing.assert_allclose(T[:, 2, 3], 0.0, atol=1e-9)
    np.testing.assert_allclose(motion.q[:, 0], motion.q[:, 6], atol=1e-6)  # least motion shares the way equally
    np.testing.assert_allclose(np.diff(motion.q, axis=0), 0.5 * (motion.qd[1:] + motion.qd[:-1]) * motion.dt, atol=1e-5)


def test_out_of_reach_without_closed_form_says_where() -> None:
    class Flat(Gantry):
        def jacobian(self, q: np.ndarray, *, frame: str) -> np.ndarray:
            return np.array(Gantry.jacobian(self, q, frame=frame))

        def ik(self, T: np.ndarray, q0: np.ndarray) -> None:
            raise InputError("no closed form")

    arm = Flat(limits_of(3))
    T1 = pose(rot_y(np.array(0.5)), np.array([1.0, 0.0, 0.0]))
    with pytest.raises(MotionError, match=r"% of the straight line, tool at .* out of the arm's reach"):
        plan_path(arm, np.zeros(3), [T1], **SPEEDS)


def test_bad_segments() -> None:
    T0 = ARM.fk(Q0)
    T1 = moved(T0, np.array([0.2, 0.0, 0.0]), np.zeros(3))
    with pytest.raises(MotionError, match="lie on one line; use a straight line"):
        plan_path(ARM, Q0, [ArcTo([0.1, 0.0, 0.0], T1)], **SPEEDS)
    with pytest.raises(OutOfLimits, match="axis of the circle"):
        plan_path(ARM, Q0, [ArcAbout([0.1, 0, 0], [0, 0, 0], 1.0)], **SPEEDS)
    with pytest.raises(ShapeError, match="center of an arc"):
        plan_path(ARM, Q0, [ArcAbout([0.1, np.nan, 0], [0, 0, 1], 1.0)], **SPEEDS)
    with pytest.raises(ShapeError, match="poses 1 and 2 of the spline are the same"):
        plan_path(ARM, Q0, [SplineTo([T1, T1])], **SPEEDS)
    with pytest.raises(NotAPose, match=r"give \(k, 4, 4\)"):
        plan_path(ARM, Q0, [SplineTo(T1)], **SPEEDS)
    with pytest.raises(NotAPose, match="goal of a line"):
        plan_path(ARM, Q0, [2 * T1], **SPEEDS)
    far = dataclasses.replace(ARM, limits=limits_of(6, reach=0.15))
    with pytest.raises(MotionError, match=r"of the circle, tool at .* joint 2 would go to"):
        plan_path(
            far,
            0.0 * Q0 + [0, 0, 0, 0.1, 0.12, 0.1],
            [ArcAbout([0.2, 0, 0], [0, 0, 1], 3.0, turn_tool=False)],
            **SPEEDS,
        )
