from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motion_arms import limits_of

from holonom.errors import InputError, MotionError, OutOfLimits, ShapeError
from holonom.mechanics.motion import plan_joint, plan_transfer

pytest.importorskip("ruckig", reason="Ruckig is not installed; pip install -e '.[motion]'")
LIMITS = limits_of(3, reach=50.0, speed=2.0, acceleration=8.0)
JERK = np.array([60.0, 80.0, 100.0])
three = arrays(np.float64, 3, elements=st.floats(-1.0, 1.0))


@settings(max_examples=40)
@given(three, three, three, three, three, three)
def test_boundary_states_and_limits(
    q0: np.ndarray, v0: np.ndarray, a0: np.ndarray, q1: np.ndarray, v1: np.ndarray, a1: np.ndarray
) -> None:
    start, goal = (q0, v0, 2.0 * a0), (3.0 * q1, v1, 2.0 * a1)
    motion = plan_transfer(start, goal, LIMITS, jerk=JERK)
    for found, first, last in zip((motion.q, motion.qd, motion.qdd), start, goal, strict=True):
        np.testing.assert_allclose(found[0], first, atol=1e-6)
        np.testing.assert_allclose(found[-1], last, atol=1e-6)
    assert (np.abs(motion.qd) <= LIMITS.speed * (1 + 1e-9)).all()
    assert (np.abs(motion.qdd) <= LIMITS.acceleration * (1 + 1e-9)).all()
    if len(motion.q) > 1:
        assert (np.abs(np.diff(motion.qdd, axis=0)) / motion.dt <= JERK * (1 + 1e-6) + 1e-6).all()
        step = 0.5 * (motion.qd[1:] + motion.qd[:-1]) * motion.dt
        np.testing.assert_allclose(np.diff(motion.q, axis=0), step, atol=1e-7)


def test_from_rest_to_rest_it_is_not_slower_than_the_s_curve() -> None:
    q1 = np.array([1.0, -0.5, 2.0])
    fast = plan_transfer((np.zeros(3),), (q1,), LIMITS, jerk=JERK)
    smooth = plan_joint(np.zeros(3), q1, LIMITS, jerk=JERK, profile="scurve")
    assert fast.duration < smooth.duration
    # rest to rest, limits reached: way / v + v / a + a / j of the joint that needs most
    assert fast.duration == pytest.approx(2.0 / 2.0 + 2.0 / 8.0 + 8.0 / 100.0, abs=2e-3)


def test_bad_input() -> None:
    rest = (np.zeros(3),)
    with pytest.raises(OutOfLimits, match=r"jerk 0\.0: give a positive"):
        plan_transfer(rest, rest, LIMITS, jerk=0.0)
    with pytest.raises(OutOfLimits, match="acceleration limit of joint 2 is 0"):
        plan_transfer(rest, rest, replace(LIMITS, acceleration=np.array([1.0, 0.0, 1.0])), jerk=1.0)
    with pytest.raises(ShapeError, match="start has 4 parts"):
        plan_transfer(rest * 4, rest, LIMITS, jerk=1.0)
    with pytest.raises(ShapeError, match="goal qd has shape"):
        plan_transfer(rest, (np.zeros(3), np.zeros(2)), LIMITS, jerk=1.0)
    with pytest.raises(OutOfLimits, match="joint 1 is to go to 60"):
        plan_transfer(rest, (np.array([60.0, 0.0, 0.0]),), LIMITS, jerk=1.0)
    with pytest.raises(MotionError, match=r"at the goal joint 1 has speed 5 .*needs speed 5; its limit is 2"):
        plan_transfer(rest, (np.zeros(3), np.full(3, 5.0)), LIMITS, jerk=1.0)
    with pytest.raises(MotionError, match=r"needs speed 3\.9; its limit is 2"):  # 1.9 + 2^2 / (2 1) before it
        plan_transfer(rest, (np.zeros(3), np.full(3, 1.9), np.full(3, -2.0)), LIMITS, jerk=1.0)
    with pytest.raises(MotionError, match="needs acceleration 9; its limit is 8"):
        plan_transfer(rest, (np.zeros(3), np.zeros(3), np.full(3, 9.0)), LIMITS, jerk=1.0)
    near = limits_of(3, reach=0.5, speed=2.0, acceleration=8.0)
    with pytest.raises(MotionError, match=r"joint 2 would go to 0\.5\d* m on the way; its limits are -0.5 to 0.5"):
        plan_transfer((np.array([0.0, 0.49, 0.0]), np.array([0.0, 1.0, 0.0])), rest, near, jerk=JERK)


def test_without_ruckig_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(InputError, match=r"pip install -e '\.\[motion\]'"):
        plan_transfer((np.zeros(3),), (np.ones(3),), LIMITS, jerk=JERK)


@pytest.mark.parametrize("way", [7500.0, 7599.0, -1e5])
def test_however_long_it_takes(way: float) -> None:
    """From rest to rest at one unit of speed, acceleration and jerk: way / v + v / a + a / j."""
    motion = plan_transfer((np.zeros(1),), (np.array([way]),), limits_of(1, reach=1e6, speed=1.0, acceleration=1.0),
                           jerk=1.0, dt=0.5)  # fmt: skip
    assert motion.duration == pytest.approx(abs(way) + 2.0, rel=1e-12)
    assert motion.q[len(motion.q) // 2, 0] == pytest.approx(way / 2.0, abs=1e-6)
    assert np.abs(motion.qd).max() == pytest.approx(1.0, abs=1e-9)


def test_what_no_motion_is_found_for_is_said_in_our_words() -> None:
    slow = limits_of(1, speed=1e-9, acceleration=1e9)
    with pytest.raises(
        MotionError, match=r"was found .positions 0 to 1.: what is asked is too long, or too short"
    ) as told:
        plan_transfer((np.zeros(1),), (np.ones(1),), slow, jerk=1e9)
    assert "uckig" not in str(told.value)
    with pytest.raises(MotionError, match=r"lasts 100002 s, more than 20000000 samples of 0\.001 s; give a longer dt="):
        plan_transfer(
            (np.zeros(1),), (np.full(1, 1e5),), limits_of(1, reach=1e6, speed=1.0, acceleration=1.0), jerk=1.0
        )


@settings(max_examples=20)
@given(three, three, three, three)
def test_samples_are_those_of_the_planner(q0: np.ndarray, v0: np.ndarray, a0: np.ndarray, q1: np.ndarray) -> None:
    """Braking into the limits, too: speeds of up to twice the limit at the start."""
    import ruckig

    motion = plan_transfer((q0, 4.0 * v0, 2.0 * a0), (3.0 * q1,), LIMITS, jerk=JERK)
    wanted, found = ruckig.InputParameter(3), ruckig.Trajectory(3)
    wanted.current_position, wanted.current_velocity, wanted.current_acceleration = q0, 4.0 * v0, 2.0 * a0
    wanted.target_position, wanted.minimum_duration = 3.0 * q1, motion.duration
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = LIMITS.speed, LIMITS.acceleration, JERK
    ruckig.Ruckig(3).calculate(wanted, found)
    for k in range(0, len(motion.q), max(1, len(motion.q) // 50)):
        q, qd, qdd = found.at_time(min(k * motion.dt, found.duration))
        np.testing.assert_allclose(motion.q[k], q, atol=1e-9)
        np.testing.assert_allclose(motion.qd[k], qd, atol=1e-8)
        np.testing.assert_allclose(motion.qdd[k], qdd, atol=1e-7)
