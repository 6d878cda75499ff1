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
    with pytest.raises(MotionError, match="no motion between these states"):
        plan_transfer(rest, (np.zeros(3), np.full(3, 5.0)), LIMITS, jerk=1.0)
    near = limits_of(3, reach=0.5, speed=2.0, acceleration=8.0)
    with pytest.raises(MotionError, match=r"joint 2 would go to 0\.5\d* on the way; its limits are -0.5 to 0.5"):
        plan_transfer((np.array([0.0, 0.49, 0.0]), np.array([0.0, 1.0, 0.0])), rest, near, jerk=JERK)


def test_without_ruckig_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(InputError, match=r"holonom\[motion\]"):
        plan_transfer((np.zeros(3),), (np.ones(3),), LIMITS, jerk=JERK)
