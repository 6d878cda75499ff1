"""Straight lines of the real arm: the laws of `test_motion_line.py` through compiled kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from holonom.errors import MotionError
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.motion import blend, plan_joint, plan_line
from holonom.spatial import pose

SPEEDS = {"speed": 0.4, "rotation_speed": 2.0, "acceleration": 2.0, "rotation_acceleration": 10.0}
MIDDLE = np.array([0.2, 0.7, -3.0, 0.2, -0.9, 0.3])


@pytest.fixture(scope="module")
def puma() -> Arm:
    return load_arm("puma560")


@settings(max_examples=20)
@given(
    arrays(np.float64, 6, elements=st.floats(-0.25, 0.25)),
    arrays(np.float64, 3, elements=st.floats(-0.1, 0.1)),
    arrays(np.float64, 3, elements=st.floats(-0.2, 0.2)),
)
def test_lines_are_straight_and_keep_every_limit(
    puma: Arm, offset: np.ndarray, shift: np.ndarray, turn: np.ndarray
) -> None:
    q0 = MIDDLE + offset
    T0 = puma.fk(q0)
    T1 = pose(T0[:3, 3] + shift, Rotation.from_rotvec(turn).as_matrix() @ T0[:3, :3])
    motion = plan_line(puma, q0, T1, **SPEEDS)
    np.testing.assert_array_equal(motion.q[0], q0)
    T = puma.fk(motion.q)
    np.testing.assert_allclose(T[-1], T1, atol=1e-9)
    np.testing.assert_allclose(np.cross(T[:, :3, 3] - T0[:3, 3], shift), 0.0, atol=1e-12)
    assert (np.abs(motion.qd) <= puma.limits.speed).all()
    assert (np.abs(motion.qdd) <= puma.limits.acceleration).all()
    assert (np.abs(motion.q - q0) < 1.5).all()
    middle = 0.5 * (motion.qd[1:] + motion.qd[:-1]) * motion.dt
    np.testing.assert_allclose(np.diff(motion.q, axis=0), middle, atol=1e-6)


def test_a_joint_motion_blends_into_a_line(puma: Arm) -> None:
    there = plan_joint(MIDDLE + 0.4, MIDDLE, puma.limits)
    T1 = puma.fk(MIDDLE).copy()
    T1[:3, 3] += [0.1, -0.15, 0.05]
    line = plan_line(puma, MIDDLE, T1, **SPEEDS)
    whole = blend(there, line, puma.limits)
    assert there.brake <= whole.begin < len(there.q) - 1
    assert (np.abs(whole.qd) <= puma.limits.speed * (1 + 1e-8)).all()
    assert (np.abs(whole.qdd) <= puma.limits.acceleration * (1 + 1e-8)).all()
    np.testing.assert_allclose(puma.fk(whole.q[-1]), T1, atol=1e-9)


@pytest.mark.parametrize(
    ("shift", "words"),
    [
        ([-2.0, 0.0, 0.0], "out of the arm's reach"),
        ([-0.5, 0.0, 0.0], r"elbow would go to -3\.92\d* rad \(-225\.\d+ deg\); its limits are -3\.92699 to 0\.785398"),
    ],
)
def test_what_cannot_be_followed_says_where_and_why(puma: Arm, shift: list[float], words: str) -> None:
    T1 = puma.fk(MIDDLE).copy()
    T1[:3, 3] += shift
    with pytest.raises(MotionError, match=rf"at \d+ % of the straight line, tool at .*({words})"):
        plan_line(puma, MIDDLE, T1, **SPEEDS)


def test_a_straight_wrist_cannot_leave_on_a_line(puma: Arm) -> None:
    q0 = MIDDLE * [1, 1, 1, 0, 0, 1]
    T1 = puma.fk(MIDDLE)
    with pytest.raises(MotionError, match="singular"):
        plan_line(puma, q0, T1, **SPEEDS)
