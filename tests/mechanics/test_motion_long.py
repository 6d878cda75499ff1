"""Long motions: samples are made when they are asked for, and are those of the whole."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from motion_arms import GantryWrist, limits_of
from scipy.spatial.transform import Rotation, Slerp

from holonom.errors import OutOfLimits
from holonom.mechanics.motion import Trajectory, blend, plan_joint, plan_line, splice, stop

LIMITS = limits_of(3)
WRIST = GantryWrist(limits_of(6))
SLOW = {"speed": 1e-4, "rotation_speed": 1.0, "acceleration": 2.0, "rotation_acceleration": 4.0}


def test_a_day_takes_no_more_memory_than_a_second() -> None:
    """86,400,000 samples of three joints would be 6 GB."""
    tracemalloc.start()
    motion = plan_joint(np.zeros(3), [1.0, -2.0, 0.5], LIMITS, speed=2.0 / (3.0 * 86_400.0))
    for k in (0, 1000, 43_000_000, motion.count - 1000):
        motion.take(k, k + 1000)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert motion.duration == pytest.approx(86_400.0, rel=1e-3)
    assert peak < 2_000_000
    with pytest.raises(OutOfLimits, match=r"lasts 86\d+ s .* use take"):
        _ = motion.q
    np.testing.assert_array_equal(motion.end, [1.0, -2.0, 0.5])
    middle = motion.take(motion.count // 2, motion.count // 2 + 1)
    np.testing.assert_allclose(middle[0, 0], [0.5, -1.0, 0.25], atol=1e-6)  # the law is symmetric
    np.testing.assert_allclose(middle[1, 0], np.array([1.0, -2.0, 0.5]) / 86_400.0, rtol=1e-3)


def test_a_long_line_is_straight_and_even() -> None:
    """0.2 m at 0.1 mm/s through a turning wrist: place and turn of every sample by the law of the line."""
    q0 = np.array([0.0, 0.0, 0.0, 0.3, 0.5, 0.2])
    q1 = np.array([0.2, 0.0, 0.0, 0.8, 0.9, -0.4])
    line = plan_line(WRIST, q0, WRIST.fk(q1), **SLOW)
    assert line.duration == pytest.approx(0.2 / 1e-4, rel=1e-3)
    T0, T1 = WRIST.fk(q0), WRIST.fk(q1)
    turn = Slerp([0.0, 1.0], Rotation.from_matrix(np.stack([T0[:3, :3], T1[:3, :3]])))
    for first in (10, 700_123, line.count - 510):
        q, qd, qdd = line.take(first, first + 500)
        T, s = WRIST.fk(q), q[:, 0] / 0.2
        np.testing.assert_allclose(T[:, 1:3, 3], 0.0, atol=1e-12)
        np.testing.assert_allclose(T[:, :3, :3], turn(s.clip(0, 1)).as_matrix(), atol=1e-9)
        np.testing.assert_allclose(np.diff(q, axis=0) / 1e-3, 0.5 * (qd[1:] + qd[:-1]), atol=1e-7)
        np.testing.assert_allclose(np.diff(qd, axis=0) / 1e-3, 0.5 * (qdd[1:] + qdd[:-1]), atol=1e-4)
    np.testing.assert_allclose(line.take(1_000_000, 1_000_001)[1, 0, 0], 1e-4, rtol=1e-6)
    np.testing.assert_allclose(line.end, q1, atol=1e-9)


def test_parts_are_those_of_the_whole() -> None:
    """Two motions blended: any stretch, and what is left from anywhere, is a stretch of all samples."""
    first = plan_joint(np.zeros(3), [1.0, 0.0, 0.0], LIMITS)
    both = blend(first, plan_joint([1.0, 0.0, 0.0], [1.0, 1.0, 0.0], LIMITS), LIMITS)
    whole = both.take(0, both.count)
    assert both.begin < first.count - 1, "they overlap"
    for a, b in (
        (0, 10),
        (both.begin - 5, both.begin + 5),
        (first.count - 5, first.count + 5),
        (both.count - 3, both.count),
    ):
        np.testing.assert_array_equal(both.take(a, b), whole[:, a:b])
        rest = both.rows.after(a)
        assert rest.count == both.count - a
        np.testing.assert_allclose(rest.take(0, rest.count), whole[:, a:], atol=1e-15)


def test_a_long_path_forgets_what_is_over() -> None:
    """Fifteen hundred motions blended as soon as each has begun: neither memory nor depth grow."""
    corners = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0], [0.0, 0.1, 0.0]])
    path, last = plan_joint(corners[0], corners[1], LIMITS), corners[0]
    for k in range(2, 1500):
        following = plan_joint(path.end, corners[k % 4], LIMITS)
        path = splice(path, path.begin, following, LIMITS)
        here = path.take(0, 2)[0]
        assert np.abs(here[1] - here[0]).max() < 4e-3
        last = here[0]
    assert np.abs(last).max() < 0.2
    assert path.count < 1000


def test_a_long_motion_is_stopped_on_its_path() -> None:
    motion = plan_joint(np.zeros(3), [1.0, -2.0, 0.5], LIMITS, speed=1e-4)
    stopped = stop(motion, motion.count // 2, LIMITS)
    assert stopped.duration < 0.1
    np.testing.assert_allclose(stopped.end / stopped.end[0], [1.0, -2.0, 0.5], atol=1e-9)
    assert isinstance(stopped, Trajectory)
