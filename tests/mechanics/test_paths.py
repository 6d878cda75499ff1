"""Branches followed along a path of poses."""

import numpy as np
import pytest

from holonom.errors import InputError, ShapeError
from holonom.mechanics import arm_from_dh, load_arm
from holonom.mechanics.paths import feasible_branches, follow
from holonom.model import DHRow, JointLimits


@pytest.fixture(scope="module")
def puma():
    return load_arm("puma560")


def path_of(arm, q0, q1, count=80):
    """Poses of a joint motion: a path that one branch is known to follow."""
    q = q0 + np.linspace(0.0, 1.0, count)[:, None] * (np.asarray(q1) - q0)
    return q, arm.fk(q)


def test_a_joint_motion_is_found_again(puma):
    q, T = path_of(puma, np.array([0.0, 0.7, -2.9, 0.3, 0.6, -0.4]), [0.8, 0.3, -2.2, 0.9, 0.9, -3.9])
    found = follow(puma, T, q[0] + 1e-3)
    assert found.feasible
    np.testing.assert_allclose(found.q, q, atol=1e-8)


def test_a_wrist_that_passes_its_straight_pose_goes_on(puma):
    """Exactly straight in the middle, where q4 is free, the motion goes on and flip has become noflip."""
    q, T = path_of(puma, np.array([0.0, 0.7, -2.9, 0.3, 0.5, -0.4]), [0.4, 0.6, -2.7, 0.3, -0.5, -0.4], 101)
    assert q[50, 4] == 0.0
    found = follow(puma, T, q[0])
    assert found.feasible
    np.testing.assert_allclose(found.q, q, atol=1e-6)
    assert found.name.endswith(" noflip")


def test_where_and_why_a_path_ends(puma):
    q, T = path_of(puma, np.array([0.0, 0.7, -2.9, 0.3, 0.6, -0.4]), [0.0, 0.7, -2.9, 0.3, 2.2, -0.4])
    found = follow(puma, T, q[0])
    over = int(np.argmax(q[:, 4] > puma.limits.upper[4]))
    assert found.reached == over
    assert f"'wrist_bend' would leave its limits at pose {over}" in found.reason
    np.testing.assert_allclose(found.q, q[:over], atol=1e-8)
    T[40:, 0, 3] += 3.0
    assert follow(puma, T, q[0]).reason == "pose 40 is out of reach"
    assert follow(puma, T[::-1], q[0]).reached == 0
    _, T = path_of(puma, q[0], q[0] + 0.4)
    T[30:] = puma.fk(q[0] + [0.0, 0.0, 0.0, 0.0, 0.0, 2.0])
    assert "'flange' would jump at pose 30" in follow(puma, T, q[0]).reason


def test_only_one_elbow_reaches_the_end():
    """A joint limit at the elbow stops one branch on the way; the other one goes through."""
    limits = [JointLimits(-4.0, 4.0), JointLimits(-2.4, 1.0)]
    arm = arm_from_dh([DHRow(a=0.3), DHRow(a=0.25)], convention="standard", name="p2", limits=limits)
    q, T = path_of(arm, np.array([0.2, -0.7]), [0.6, -2.0])
    paths = feasible_branches(arm, T)
    assert [p.name for p in paths] == ["lefty", "righty"]
    assert [p.feasible for p in paths] == [True, False]
    np.testing.assert_allclose(paths[0].q, q, atol=1e-9)
    assert "'joint2' would leave its limits" in paths[1].reason
    assert 0 < paths[1].reached < len(q)


def test_whole_turns_are_chosen_for_the_whole_way():
    """The pose alone says q = 3 - 2 pi at the start; only 3 to 5 lies within the limits all the way."""
    arm = arm_from_dh(
        [DHRow(a=0.3), DHRow(a=0.25)], convention="standard", name="p2", limits=[JointLimits(-3.5, 5.5)] * 2
    )
    q, T = path_of(arm, np.array([-3.2 + 2 * np.pi, 0.7]), [5.2, 0.9])
    best = feasible_branches(arm, T)[0]
    assert best.feasible
    np.testing.assert_allclose(best.q, q, atol=1e-9)


def test_every_feasible_branch_follows_the_path(puma):
    q, T = path_of(puma, np.array([0.0, 0.7, -2.9, 0.3, 0.6, -0.4]), [0.3, 0.5, -2.6, 0.5, 0.9, -0.9])
    paths = feasible_branches(puma, T)
    feasible = [p for p in paths if p.feasible]
    assert feasible == paths[: len(feasible)]
    assert any(np.abs(p.q - q).max() < 1e-8 for p in feasible)
    for p in paths:
        assert p.reached == len(p.q)
        np.testing.assert_allclose(puma.fk(p.q), T[: p.reached], atol=1e-8)
        assert np.abs(np.diff(p.q, axis=0)).max(initial=0.0) < 0.5
        assert ((p.q >= puma.limits.lower - 1e-9) & (p.q <= puma.limits.upper + 1e-9)).all()


def test_bad_paths_are_named(puma):
    with pytest.raises(ShapeError, match="path"):
        follow(puma, np.eye(4), np.zeros(6))
    with pytest.raises(ShapeError, match="q0"):
        follow(puma, puma.fk(np.zeros((2, 6))), np.zeros(5))
    with pytest.raises(InputError, match="jump"):
        feasible_branches(puma, puma.fk(np.zeros((2, 6))), jump=0.0)
