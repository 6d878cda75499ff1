from __future__ import annotations

from functools import reduce
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from motion_arms import Gantry, limits_of, pose

from holonom.errors import MotionError
from holonom.mechanics.motion import PROFILES, Trajectory, blend, plan_joint, plan_line, splice, stop

n = 3
limits = limits_of(n, reach=3.0, speed=2.0, acceleration=10.0)
position = arrays(np.float64, n, elements=st.floats(-3.0, 3.0)).map(lambda q: np.round(q, 6))
via_points = st.lists(position, min_size=3, max_size=6)
profiles = st.sampled_from(sorted(PROFILES))
DT = 4e-3


def joint_motions(points: list[np.ndarray], profile: str = "scurve") -> list[Trajectory]:
    return [plan_joint(a, b, limits, dt=DT, profile=profile, line=i) for i, (a, b) in enumerate(pairwise(points))]


def check_limits(motion: Trajectory) -> None:
    assert (np.abs(motion.qd) <= limits.speed * (1 + 1e-8)).all()
    assert (np.abs(motion.qdd) <= limits.acceleration * (1 + 1e-8)).all()
    assert (np.abs(motion.q) <= 3.0 + 1e-12).all()


def check_smooth(motion: Trajectory) -> None:
    """No step of position or speed: each is what the next derivative explains, within a sample's acceleration."""
    step = limits.acceleration * DT
    assert (np.abs(np.diff(motion.qd, axis=0)) <= step * (1 + 1e-8)).all()
    middle = 0.5 * (motion.qd[1:] + motion.qd[:-1]) * DT
    assert (np.abs(np.diff(motion.q, axis=0) - middle) <= step * DT / 4 + 1e-12).all()


@settings(max_examples=60, deadline=None)
@given(via_points, profiles)
def test_blended_motions_keep_limits_and_ends(points: list[np.ndarray], profile: str) -> None:
    motions = joint_motions(points, profile)
    whole = reduce(lambda a, b: blend(a, b, limits), motions)
    check_limits(whole)
    check_smooth(whole)
    np.testing.assert_array_equal(whole.q[0], points[0])
    np.testing.assert_array_equal(whole.q[-1], points[-1])
    assert not whole.qd[-1].any()
    assert whole.duration <= sum(m.duration for m in motions) + 1e-9


@settings(max_examples=60, deadline=None)
@given(via_points, profiles, st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5))
def test_splicing_into_a_running_motion(points: list[np.ndarray], profile: str, fractions: list[float]) -> None:
    motions = joint_motions(points, profile)
    current, sent = motions[0], []
    for following, fraction in zip(motions[1:], fractions, strict=False):
        consumed = int(fraction * len(current.q))
        before = current.q.copy()
        spliced = splice(current, consumed, following, limits)
        np.testing.assert_array_equal(current.q, before)
        if consumed < len(current.q):
            np.testing.assert_array_equal(spliced.q[0], current.q[consumed])
            np.testing.assert_array_equal(spliced.qd[0], current.qd[consumed])
        untouched = max(min(current.brake, len(current.q) - 1) - consumed, 0)
        np.testing.assert_array_equal(spliced.q[:untouched], current.q[consumed : consumed + untouched])
        sent.append((current.q[:consumed], current.qd[:consumed], current.qdd[:consumed]))
        current = spliced
    sent.append((current.q, current.qd, current.qdd))
    whole = Trajectory(DT, *(np.concatenate(part) for part in zip(*sent, strict=True)))
    check_limits(whole)
    check_smooth(whole)
    np.testing.assert_array_equal(whole.q[-1], points[-1])


def test_two_equal_collinear_motions_run_through_at_full_speed() -> None:
    first, second = joint_motions([np.zeros(n), np.ones(n), 2.0 * np.ones(n)])
    whole = blend(first, second, limits)
    through = slice(first.brake, whole.brake)
    np.testing.assert_allclose(whole.qd[through] - whole.qd[first.brake], 0.0, atol=1e-12)
    assert whole.begin == first.brake
    assert whole.line == 1


def test_reversing_leaves_little_overlap_but_some() -> None:
    first, second = joint_motions([np.zeros(n), np.ones(n), np.zeros(n)])
    ramp = len(first.q) - 1 - first.brake
    overlap = len(first.q) - 1 - blend(first, second, limits).begin
    # Two parabolas 4x(1 - x) that together stay below their own top overlap by 1 - sqrt(1/2) of a ramp.
    assert 0.25 < overlap / ramp < 0.2930


def test_no_room_at_all_is_a_full_stop() -> None:
    trapezoids = joint_motions([np.zeros(n), np.ones(n), np.zeros(n)], "trapezoid")
    whole = blend(*trapezoids, limits)
    assert whole.begin == len(trapezoids[0].q) - 1
    assert not whole.qd[whole.begin].any()
    assert whole.duration == pytest.approx(sum(m.duration for m in trapezoids))


def test_the_sum_of_speeds_is_kept() -> None:
    first = plan_joint(np.zeros(n), np.ones(n), limits, dt=DT, acceleration=0.2)
    second = plan_joint(np.ones(n), 3.0 * np.ones(n), limits, dt=DT)
    whole = blend(first, second, limits)
    assert first.qd[first.brake].max() + second.qd.max() > limits.speed[0]
    check_limits(whole)


def test_the_sum_of_accelerations_is_kept_on_every_sample() -> None:
    # Few samples to a ramp: the sums at a sample pass the limit where the means between samples do not.
    there = plan_joint(np.zeros(n), np.ones(n), limits, dt=0.05)
    for way in np.linspace(0.3, 0.7, 41):
        check_limits(blend(there, plan_joint(np.ones(n), (1.0 - way) * np.ones(n), limits, dt=0.05), limits))


def test_a_sum_does_not_leave_the_positions() -> None:
    # Two motions on one side of where they meet, at the limit of 3 together; their speeds are not at issue.
    rest = np.zeros((5, 1))
    first = Trajectory(DT, np.array([[2.9], [2.9], [2.9], [2.8], [2.8]]), rest, rest)
    second = Trajectory(DT, np.array([[2.8], [2.95], [2.95], [2.95], [2.95]]), rest, rest, brake=4)
    one = limits_of(1, reach=3.0)
    assert blend(first, second, one).q.max() == 2.95
    wide = blend(first, second, limits_of(1, reach=4.0))
    assert wide.q.max() == pytest.approx(3.05)


def test_splicing_early_gives_what_blending_gives() -> None:
    first, second = joint_motions([np.zeros(n), np.ones(n), [1.0, 2.0, -1.0]])
    whole, spliced = blend(first, second, limits), splice(first, 20, second, limits)
    np.testing.assert_array_equal(spliced.q, whole.q[20:])
    assert (spliced.begin, spliced.brake) == (whole.begin - 20, whole.brake - 20)


def test_a_short_second_motion_overlaps_by_at_most_its_first_half() -> None:
    first, second = joint_motions([np.zeros(n), np.ones(n), 1.02 * np.ones(n)])
    whole = blend(first, second, limits)
    assert whole.begin >= len(first.q) - 1 - len(second.q) // 2
    assert whole.brake >= len(first.q) - 1


def test_late_splices_stop_first() -> None:
    first, second = joint_motions([np.zeros(n), np.ones(n), 2.0 * np.ones(n)])
    whole = splice(first, len(first.q), second, limits)
    np.testing.assert_array_equal(whole.q, second.q)
    late = splice(first, len(first.q) - 5, second, limits)
    np.testing.assert_array_equal(late.q[0], first.q[-5])
    assert late.begin <= 4


def test_a_motion_of_no_length_changes_nothing() -> None:
    first, still = joint_motions([np.zeros(n), np.ones(n), np.ones(n)])
    assert blend(first, still, limits) is first
    np.testing.assert_array_equal(blend(still, joint_motions([np.ones(n), np.zeros(n)])[0], limits).q[0], 1.0)


def test_motions_have_to_meet() -> None:
    first, second = joint_motions([np.zeros(n), np.ones(n), 2.0 * np.ones(n)])
    with pytest.raises(MotionError, match=r"line 0 starts 2 .* of joint 1 away"):
        blend(second, first, limits)
    with pytest.raises(MotionError, match="plan both with one dt"):
        blend(first, plan_joint(np.ones(n), np.zeros(n), limits, dt=1e-3), limits)
    with pytest.raises(MotionError, match="give 0 to"):
        splice(first, len(first.q) + 1, second, limits)


def circle(chords: int, radius: float, speed: float) -> tuple[Trajectory, np.ndarray]:
    arm = Gantry(limits_of(3, speed=5.0, acceleration=50.0))
    angle = np.linspace(0.0, 2 * np.pi, chords + 1)
    corners = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    lines = [
        plan_line(
            arm,
            a,
            pose(np.eye(3), b),
            speed=speed,
            rotation_speed=1.0,
            acceleration=4.0,
            rotation_acceleration=1.0,
        )
        for a, b in pairwise(corners)
    ]
    return reduce(lambda a, b: blend(a, b, arm.limits), lines), corners


@pytest.mark.parametrize("speed", [0.1, 0.2])
def test_a_circle_of_chords_is_drawn_at_nearly_constant_speed(speed: float) -> None:
    radius, chords = 0.1, 36
    motion, _ = circle(chords, radius, speed)
    tool = np.linalg.norm(motion.qd, axis=1)
    ramp = round(1.5 * speed / 4.0 / motion.dt) + 2
    half = np.cos(np.pi / chords)
    assert tool.max() <= speed * (1 + 1e-9)
    # At a corner's middle the two halves of the speed enclose the angle of the corner.
    assert tool[ramp:-ramp].min() >= 0.96 * speed * half
    assert motion.duration == pytest.approx(2 * np.pi * radius / speed, rel=0.05)
    apart = np.linalg.norm(motion.q, axis=1)
    assert radius * half - 1e-3 < apart.min()
    assert apart.max() <= radius * (1 + 1e-12)


def test_the_path_leaves_the_chords_only_near_the_corners() -> None:
    motion, corners = circle(12, 0.1, 0.1)
    a, b = corners[:-1], corners[1:]
    along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    offset = motion.q[:, None] - a
    part = np.clip(np.sum(offset * along, axis=2), 0.0, np.linalg.norm(b - a, axis=1))
    deviation = np.linalg.norm(offset - part[..., None] * along, axis=2).min(axis=1)
    to_corner = np.linalg.norm(motion.q[:, None] - corners, axis=2).min(axis=1)
    reach = 0.5 * 0.1 * (1.5 * 0.1 / 4.0) + 2e-4  # half the way of a ramp
    assert deviation[to_corner > reach].max() < 1e-12
    assert 1e-5 < deviation.max() < reach


@settings(max_examples=60, deadline=None)
@given(via_points, profiles, st.floats(0.0, 1.0))
def test_a_stop_stays_on_the_path_within_the_limits(points: list[np.ndarray], profile: str, fraction: float) -> None:
    whole = reduce(lambda a, b: blend(a, b, limits), joint_motions(points, profile))
    consumed = min(int(fraction * len(whole.q)), len(whole.q) - 1)
    stopped = stop(whole, consumed, limits)
    np.testing.assert_array_equal(stopped.q[0], whole.q[consumed])
    np.testing.assert_array_equal(stopped.qd[0], whole.qd[consumed])
    assert not stopped.qd[-1].any()
    assert (np.abs(stopped.qd) <= limits.speed * (1 + 1e-3)).all()
    assert (np.abs(stopped.qdd) <= limits.acceleration * (1 + 1e-3)).all()
    assert (np.abs(np.diff(stopped.qd, axis=0)) <= limits.acceleration * DT * 1.001).all()
    assert stopped.duration <= whole.duration - consumed * DT + 2 * DT
    for q in stopped.q[:: max(len(stopped.q) // 10, 1)]:
        gap = np.abs(whole.q - q).max(axis=1).min()
        assert gap <= np.max(limits.speed) * DT


def test_a_stop_from_a_cruise_brakes_at_the_limit() -> None:
    motion = joint_motions([-3.0 * np.ones(n), 3.0 * np.ones(n)])[0]
    stopped = stop(motion, len(motion.q) // 2, limits)
    assert stopped.duration == pytest.approx(2.0 / 10.0, abs=2 * DT)
    np.testing.assert_allclose(stopped.qdd[:-2], -10.0, rtol=1e-6)
    middle = 0.5 * (stopped.qd[1:] + stopped.qd[:-1]) * DT
    np.testing.assert_allclose(np.diff(stopped.q, axis=0), middle, atol=1e-9)


def test_a_stop_before_a_reversal_does_not_go_on_behind_it() -> None:
    motions = joint_motions([np.zeros(n), 1.25 * np.ones(n), np.zeros(n)], "trapezoid")
    whole = blend(*motions, limits)
    consumed = motions[0].brake + 20
    assert stop(whole, consumed, limits).duration <= motions[0].duration - consumed * DT + 2 * DT


def test_a_stop_at_rest_stands_still() -> None:
    motion = joint_motions([np.zeros(n), np.ones(n)])[0]
    np.testing.assert_array_equal(stop(motion, 0, limits).q, motion.q[:1])
    np.testing.assert_array_equal(stop(motion, len(motion.q), limits).q, motion.q[-1:])
