"""Which of all solutions is taken: the nearest of singular branches, one tolerance for limits, no far restarts.

Truth: the joints that a pose was made from, which are at distance 0; solution sets sampled by their own formula.
"""

import numpy as np
import pytest
from closed_form_arms import calibrated

from holonom.mechanics import IkStatus, arm_from_dh, load_arm
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.numerical_inverse import InverseStatus, solve_inverse
from holonom.mechanics.paths import follow
from holonom.model import ArmModel, DHRow, Joint, JointLimits, Mimic, constant_transform, preset

QUARTER = np.pi / 2
REACHED = (IkStatus.OK, IkStatus.SINGULAR)


def within(arm, rng, rows):
    """Random joints within the limits, of which the open ones count half a turn each side."""
    return rng.uniform(np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi), (rows, arm.n))


@pytest.mark.parametrize(
    ("name", "straight"), [("puma560", 0.0), ("stanford", 0.0), ("ur5e", 0.0), ("ur5e", np.pi), ("ur5e", -np.pi)]
)
def test_joints_at_the_singular_wrist_are_their_own_nearest(name, straight):
    arm, rng = load_arm(name), np.random.default_rng(0)
    q = within(arm, rng, 500)
    q[:, 4] = straight
    near = arm.ik_nearest(arm.fk(q), q)
    assert np.isin(near.status, REACHED).all()
    np.testing.assert_allclose(near.q, q, rtol=0.0, atol=1e-6)
    for k in range(0, 500, 50):
        np.testing.assert_allclose(arm.ik_nearest(arm.fk(q[k]), q[k]).q, q[k], rtol=0.0, atol=1e-6)


def elbow_arm(skew=QUARTER):
    """Six joints with a spherical wrist, whose wrist passes through axis 1."""
    rows = [
        DHRow(d=0.4, alpha=QUARTER), DHRow(a=0.5), DHRow(alpha=QUARTER),
        DHRow(d=0.5, alpha=-skew), DHRow(alpha=skew), DHRow(d=0.1),
    ]  # fmt: skip
    return arm_from_dh(rows, convention="standard")


def shoulder_and(q):
    q[:, 2] = np.arcsin(-np.cos(q[:, 1])) - q[:, 1]  # a2 cos q2 + d4 sin(q2 + q3) = 0: the wrist on axis 1
    return q


def stretched_and(q):
    q[:, 2], q[:, 4] = QUARTER, 0.0
    return q


def straight_and(q):
    q[:, 4] = 0.0
    return q


@pytest.mark.parametrize(
    ("arm", "singular"),
    [
        (elbow_arm(), shoulder_and),
        (elbow_arm(), lambda q: straight_and(shoulder_and(q))),
        (elbow_arm(), stretched_and),
        (elbow_arm(1.0), straight_and),
        (elbow_arm(-0.7), straight_and),
    ],
    ids=["shoulder", "shoulder and wrist", "stretched, wrist straight", "skew wrist", "skew the other way"],
)
def test_other_singular_joints_are_their_own_nearest(arm, singular):
    q = singular(np.random.default_rng(1).uniform(-3.0, 3.0, (120, 6)))
    near = arm.ik_nearest(arm.fk(q), q)
    assert np.isin(near.status, REACHED).all()
    np.testing.assert_allclose(near.q, q, rtol=0.0, atol=1e-6)


def stretched_puma(q):
    q[:, 2], q[:, 4] = -np.arctan2(0.4318, 0.0203), 0.0
    return q


def upright_stanford(q):
    q[:, 1], q[:, 4] = 0.0, 0.0
    return q


@pytest.mark.parametrize(
    ("name", "singular"), [("ur5e", straight_and), ("puma560", stretched_puma), ("stanford", upright_stanford)]
)
@pytest.mark.parametrize("off", [1e-7, 1e-3, 0.02])
def test_near_to_singular_joints_nothing_far_is_taken(name, singular, off):
    """A solution lies within `off` of the reference: the joints that the pose was made from."""
    arm, rng = load_arm(name), np.random.default_rng(6)
    q = singular(within(arm, rng, 60))
    q0 = q + rng.uniform(-off, off, q.shape)
    near = arm.ik_nearest(arm.fk(q), q0)
    assert np.isin(near.status, REACHED).all()
    away = np.abs(near.q - q0).max(-1)
    assert (away < 2.0 * off + 1e-6).mean() > 0.98
    assert away.max() < 10.0 * off + 1e-6
    np.testing.assert_allclose(arm.fk(near.q), arm.fk(q), atol=1e-8)


@pytest.mark.parametrize("name", ["ur5e", "puma560"])
def test_near_to_a_singular_pose_of_a_calibrated_arm_nothing_far_is_taken(name):
    arm, rng = calibrated(name, 1), np.random.default_rng(11)
    q = straight_and(0.9 * within(arm, rng, 100))
    q0 = q + rng.uniform(-0.02, 0.02, q.shape)
    near = arm.ik_nearest(arm.fk(q), q0)
    assert np.isin(near.status, REACHED).all()
    away = np.abs(near.q - q0).max(-1)
    assert (away < 0.05).mean() > 0.9  # of two solutions close to each other the other one, now and then
    assert away.max() < 0.3
    np.testing.assert_allclose(arm.fk(near.q), arm.fk(q), atol=1e-8)


def test_no_solution_of_the_whole_set_is_nearer():
    """At q5 = 0 of the Puma q4 + q6 is what is given: the set is a line, sampled here within the limits."""
    arm, rng = load_arm("puma560"), np.random.default_rng(5)
    q, q0 = within(arm, rng, 25), within(arm, rng, 25)
    q[:, 4] = 0.0
    T = arm.fk(q)
    near, found = arm.ik_nearest(T, q0), arm.ik(T)
    np.testing.assert_allclose(arm.fk(near.q), T, atol=1e-8)
    q4 = np.linspace(arm.limits.lower[3], arm.limits.upper[3], 2001)
    turns = 2.0 * np.pi * np.arange(-2, 3)
    for k in range(25):
        least = np.inf
        for branch, status in zip(found.q[k], found.status[k], strict=True):
            members = np.repeat(branch[None], q4.size * 5, axis=0)
            if status in (IkStatus.SINGULAR, IkStatus.SINGULAR_LIMIT):
                members[:, 3] = np.tile(q4, 5)
                members[:, 5] = branch[3] + branch[5] - members[:, 3] + np.repeat(turns, q4.size)
            elif status != IkStatus.OK:
                continue
            inside = ((members >= arm.limits.lower) & (members <= arm.limits.upper)).all(-1)
            away = np.abs(members - q0[k])
            least = min(least, away.max(-1)[inside].min(initial=np.inf))
        assert np.abs(near.q[k] - q0[k]).max() <= least + 1e-9


def test_a_path_through_the_straight_wrist_steps_no_more_than_it_does():
    for name in ("puma560", "ur5e", "stanford"):
        arm = load_arm(name)
        rng = np.random.default_rng(3)
        for _ in range(4):
            q0 = 0.7 * within(arm, rng, 1)[0]
            q0[2] = 0.3 * arm.limits.lower[2] + 0.7 * arm.limits.upper[2]  # the elbow is neither stretched nor folded
            q1 = q0 + rng.uniform(-0.2, 0.2, 6)
            q0[4], q1[4] = -0.4, 0.4
            q = q0 + np.linspace(0.0, 1.0, 201)[:, None] * (q1 - q0)  # row 100 is singular
            found = follow(arm, arm.fk(q), q[0])
            assert found.feasible, found.reason
            assert np.abs(np.diff(found.q, axis=0)).max() < 1.01 * np.abs(np.diff(q, axis=0)).max()
            from_the_middle = follow(arm, arm.fk(q[100:]), q[100])
            np.testing.assert_allclose(from_the_middle.q, q[100:], atol=1e-6)


@pytest.mark.parametrize("joint", [0, 1, 2, 3, 5])
def test_joints_at_plus_and_minus_pi_keep_their_branch(joint):
    limits = [JointLimits(-np.pi, np.pi)] * 6
    rows = [
        DHRow(d=0.4, alpha=QUARTER), DHRow(a=0.5), DHRow(a=0.02, alpha=QUARTER),
        DHRow(d=0.5, alpha=-QUARTER), DHRow(alpha=QUARTER), DHRow(d=0.1),
    ]  # fmt: skip
    arm = arm_from_dh(rows, convention="standard", limits=limits)
    rng = np.random.default_rng(2)
    q = rng.uniform(-np.pi, np.pi, (400, 6))
    q[:, joint] = rng.choice([-np.pi, np.pi], 400)
    near = arm.ik_nearest(arm.fk(q), q)
    np.testing.assert_allclose(near.q, q, rtol=0.0, atol=1e-6)
    assert (near.status == IkStatus.OK).all()
    rounded = q.astype(np.float32).astype(float)  # some pass pi by 9e-8
    assert (np.abs(rounded) > np.pi).any()
    found = solve_inverse(arm, arm.fk(q[:40]), rounded[:40])
    assert (found.status == InverseStatus.OK).all()
    assert (arm.ik_nearest(arm.fk(q), rounded).status == IkStatus.OK).all()


def test_restarts_are_not_taken_for_the_nearest():
    arm, rng = load_arm("panda"), np.random.default_rng(3)
    q = rng.uniform(arm.limits.lower, arm.limits.upper, (2000, 7))
    q0 = np.clip(q + rng.uniform(-0.05, 0.05, q.shape), arm.limits.lower, arm.limits.upper)
    T = arm.fk(q)
    near = arm.ik_nearest(T, q0)
    away = np.abs(near.q - q0).max(-1)
    assert not ((near.status == IkStatus.OK) & (away > 0.3)).any()
    assert (near.status == IkStatus.OK).mean() > 0.999
    np.testing.assert_allclose(arm.fk(near.q), T, atol=1e-6)
    far = arm.ik_nearest(T[:20], within(arm, rng, 20))
    assert (np.abs(far.q - q0[:20]).max(-1) > 0.3).any()
    assert np.isin(far.status, (IkStatus.OK, IkStatus.FAR)).all()
    assert (far.status == IkStatus.FAR).any()
    np.testing.assert_allclose(arm.fk(far.q), T[:20], atol=1e-6)


def test_a_dense_path_of_a_redundant_arm_has_no_jump_that_is_called_near():
    arm, rng = load_arm("panda"), np.random.default_rng(1)
    for _ in range(3):
        q0, q1 = within(arm, rng, 2)
        q, way = q0, q0 + np.linspace(0.0, 1.0, 200)[1:, None] * (q1 - q0)
        for T in arm.fk(way):
            near = arm.ik_nearest(T, q)
            if near.status == IkStatus.OK:
                assert np.abs(near.q - q).max() < 0.3
                q = near.q


def test_weights_of_an_arm_without_a_closed_form_count():
    """Along the Panda's self-motion a joint that counts more moves less."""
    arm, rng = load_arm("panda"), np.random.default_rng(4)
    q = rng.uniform(0.7 * arm.limits.lower, 0.7 * arm.limits.upper, (40, 7))
    T = arm.fk(q)
    q0 = q + rng.uniform(-0.1, 0.1, q.shape)
    even, first = arm.ik_nearest(T, q0), arm.ik_nearest(T, q0, weights=[50.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    moved = [np.median(np.abs(near.q - q0)[:, 0]) for near in (even, first)]
    assert moved[1] < 0.1 * moved[0]


# --- limits of everything that moves ----------------------------------------------------------------------------------


def follower_arm(multiplier=1.0, offset=0.0, follower=JointLimits(-0.5, 0.5, 1.0, 2.0, 3.0)):
    """Three parallel joints in a plane; the third follows the second."""
    ahead = constant_transform(np.array([[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]))
    joints = (
        Joint("j1", "revolute", after=ahead, limits=JointLimits(-3.0, 3.0)),
        Joint("j2", "revolute", after=ahead, limits=JointLimits(-2.0, 2.0, 4.0, 8.0, 5.0)),
        Joint("j3", "revolute", after=ahead, limits=follower, mimic=Mimic(1, multiplier, offset)),
    )
    return Arm(ArmModel("follower", joints))


@pytest.mark.parametrize(
    ("multiplier", "offset", "expected"),
    [
        (1.0, 0.0, (-0.5, 0.5, 1.0, 2.0, 3.0)),
        (-2.0, 0.1, (-0.2, 0.3, 0.5, 1.0, 5.0)),  # -0.5 <= 0.1 - 2 q <= 0.5; a torque of 3 weighs 6 on the leader
        (0.25, 0.0, (-2.0, 2.0, 4.0, 8.0, 0.75)),
        (0.0, 0.1, (-2.0, 2.0, 4.0, 8.0, 5.0)),
    ],
)
def test_limits_of_a_follower_narrow_those_of_its_leader(multiplier, offset, expected):
    limits = follower_arm(multiplier, offset).limits
    got = [row[1] for row in (limits.lower, limits.upper, limits.speed, limits.acceleration, limits.torque)]
    np.testing.assert_allclose(got, expected)


def test_solvers_keep_the_limits_of_followers():
    arm = follower_arm()
    T = arm.fk([0.3, 1.5])  # the follower at 1.5: its limits are +-0.5
    plane = {"weights": (1, 1, 0, 0, 0, 0), "weights_frame": "world", "restarts": 20}
    assert solve_inverse(arm, T, **plane).status != InverseStatus.OK
    assert arm.ik_nearest(T, [0.3, 0.4]).status in (IkStatus.LIMIT, IkStatus.UNREACHABLE)
    assert solve_inverse(arm, arm.fk([0.3, 0.4]), [0.2, 0.2], **plane).status == InverseStatus.OK


@pytest.mark.parametrize("stroke", [10.0, 1e5, 1e9, np.inf])
def test_a_placeholder_for_a_limit_is_no_length_scale(stroke):
    """A Puma on a rail: the same poses are found whatever limits the rail is given."""
    across = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
    puma = preset("puma560")
    rail = Joint(
        "rail", "prismatic", constant_transform(across), constant_transform(across.T), JointLimits(-stroke, stroke)
    )
    arm = Arm(ArmModel("rail", (rail, *puma.joints), tool=puma.tool))
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 7))
    found = solve_inverse(arm, arm.fk(q))
    assert (found.status == InverseStatus.OK).all()
