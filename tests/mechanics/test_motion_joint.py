from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motion_arms import Limits, limits_of

from holonom.errors import OutOfLimits, ShapeError
from holonom.mechanics.motion import PROFILES, plan_joint

n = 4
position = arrays(np.float64, n, elements=st.floats(-3.0, 3.0))
rate = arrays(np.float64, n, elements=st.floats(0.5, 10.0))
some_limits = st.builds(lambda v, a: Limits(-3.0 * np.ones(n), 3.0 * np.ones(n), v, a), rate, rate)
profiles = st.sampled_from(sorted(PROFILES))


@given(position, position, some_limits, profiles, st.floats(0.1, 1.0), st.floats(0.1, 1.0))
def test_limits_ends_and_derivatives(
    q0: np.ndarray, q1: np.ndarray, limits: Limits, profile: str, speed: float, acceleration: float
) -> None:
    dt = 5e-3
    motion = plan_joint(q0, q1, limits, speed=speed, acceleration=acceleration, dt=dt, profile=profile, line=7)
    assert motion.line == 7
    assert motion.q.shape == motion.qd.shape == motion.qdd.shape
    assert motion.duration == pytest.approx((len(motion.q) - 1) * dt)
    np.testing.assert_allclose(motion.q[0], q0, rtol=0, atol=1e-12 if len(motion.q) == 1 else 0.0)
    np.testing.assert_array_equal(motion.q[-1], q1)
    assert not motion.qd[[0, -1]].any()
    assert not motion.qdd[[0, -1]].any()
    assert (np.abs(motion.qd) <= speed * limits.speed * (1 + 1e-8)).all()
    assert (np.abs(motion.qdd) <= acceleration * limits.acceleration * (1 + 1e-8)).all()
    if len(motion.q) > 1:
        # the trapezoid rule errs by dt^3/12 of the jerk; where the acceleration jumps, nothing is lost on a sample
        middle = 0.5 * (motion.qd[1:] + motion.qd[:-1])
        allowed = dt * dt * np.max(limits.acceleration) + 1e-12
        assert np.abs(np.diff(motion.q, axis=0) / dt - middle).max() * dt <= allowed / 4


@given(position, position, some_limits)
def test_joints_leave_and_arrive_together_and_one_is_at_its_limit(
    q0: np.ndarray, q1: np.ndarray, limits: Limits
) -> None:
    motion = plan_joint(q0, q1, limits, dt=1e-3)
    moves = np.abs(q1 - q0) > 1e-3
    assert (np.abs(motion.qd[1:-1, moves]) > 0.0).all()
    if moves.any() and motion.duration > 0.2:
        use = max(np.max(np.abs(motion.qd) / limits.speed), np.max(np.abs(motion.qdd) / limits.acceleration))
        assert use > 0.95


@given(position, position, some_limits, profiles)
def test_the_way_back_is_the_way_there_backwards(q0: np.ndarray, q1: np.ndarray, limits: Limits, profile: str) -> None:
    there = plan_joint(q0, q1, limits, dt=5e-3, profile=profile)
    back = plan_joint(q1, q0, limits, dt=5e-3, profile=profile)
    np.testing.assert_allclose(back.q, there.q[::-1], atol=1e-12)
    np.testing.assert_allclose(back.qd, -there.qd[::-1], atol=1e-12)
    np.testing.assert_allclose(back.qdd, there.qdd[::-1], atol=1e-9)


def test_a_jerk_limit_is_kept_by_every_joint() -> None:
    jerk = np.array([50.0, 20.0, 80.0])
    motion = plan_joint(np.zeros(3), [1.0, -0.4, 2.0], limits_of(3), jerk=jerk)
    measured = np.max(np.abs(np.diff(motion.qdd, axis=0)), axis=0) / motion.dt
    assert (measured <= jerk * (1 + 1e-6)).all()
    assert np.max(measured / jerk) > 0.95


def test_no_way_is_one_sample_at_rest() -> None:
    motion = plan_joint([0.1, 0.2], [0.1, 0.2], limits_of(2))
    assert motion.q.tolist() == [[0.1, 0.2]]
    assert motion.duration == 0.0


def test_a_goal_outside_its_limits_names_joint_value_and_limit() -> None:
    with pytest.raises(OutOfLimits, match=r"joint 2 is to go to 10\.5 m; its limits are -10 to 10"):
        plan_joint([0.0, 0.0], [1.0, 10.5], limits_of(2))


@pytest.mark.parametrize("fraction", [0.0, 1.5, float("nan")])
def test_fractions_end_at_one(fraction: float) -> None:
    with pytest.raises(OutOfLimits, match="speed fraction"):
        plan_joint([0.0], [1.0], limits_of(1), speed=fraction)
    with pytest.raises(OutOfLimits, match="acceleration fraction"):
        plan_joint([0.0], [1.0], limits_of(1), acceleration=fraction)


@pytest.mark.parametrize("bad", [[0.0], [[0.0, 0.0]], [0.0, float("nan")]])
def test_bad_vectors(bad: list[float]) -> None:
    with pytest.raises(ShapeError, match="q1"):
        plan_joint([0.0, 0.0], bad, limits_of(2))
