"""Closed forms of arms that are given by their axes in space: few joints, skew wrists, trees, calibrated arms.

Truth: the joints that a pose was made from are among the branches, and every branch that counts as reached reaches it.
"""

import dataclasses

import numpy as np
import pytest
from closed_form_arms import apart, calibrated, fk, form_of, miss, solve
from peers import eaik_robot
from scipy.spatial.transform import Rotation

from holonom.errors import ShapeError
from holonom.mechanics import Arm, IkStatus
from holonom.mechanics.kernels.inverse.closed_form import closed_form
from holonom.mechanics.paths import follow
from holonom.model import ArmModel, Joint, JointLimits, Mimic, constant_transform, preset, tool_chain

RNG = np.random.default_rng

AXES = {
    # What the letters say of each axis: its direction, and the point that it passes through; "." is any other.
    "2 || 3 || 4, skew wrist": ".. a. a. a. .. ..",
    "3 || 4 || 5, skew shoulder": ".. .. a. a. a. ..",
    "2 || 3 || 4, 5 || 6": ".. a. a. a. b. b.",
    "1 || 2, 3 || 4 || 5": "b. b. a. a. a. ..",
    "five, 4 meets 5": ".. .. .. .p .p",
    "five, 4 meets 5, 2 || 3": ".. a. a. .p .p",
    "five, 1 meets 2": ".p .p .. .. ..",
    "five, 2 || 3 || 4": ".. a. a. a. ..",
    "five, 1 || 2 || 3": "a. a. a. .. ..",
    "five, 1 || 2 || 3 and 4 || 5": "a. a. a. b. b.",
    "five, 1 || 2 || 3, 4 meets 5": "a. a. a. .p .p",
    "five, 1 || 2 and 3 || 4 || 5": "b. b. a. a. a.",
    "five, 3 meets 4": ".. .. .p .p ..",
    "five, 3 meets 4, 2 || 3": ".. a. ap .p ..",
    "five, 3 meets 4, 2 || 3, 4 || 5": ".. a. ap bp b.",
    "five, 3 meets 4, 1 || 2": "a. a. .p .p ..",
    "five, 2 meets 3": ".. .p .p .. ..",
    "five, 3, 4, 5 meet": ".. .. .p .p .p",
    "five, 3, 4, 5 meet, 1 || 2": "a. a. .p .p .p",
    "five, 1, 2, 3 meet": ".p .p .p .. ..",
    "four, any": ".. .. .. ..",
    "four, 1 || 2 || 3": "a. a. a. ..",
    "four, 2 || 3 || 4": ".. a. a. a.",
    "four, 1 || 2": "a. a. .. ..",
}


def random_axes(pattern, seed):
    """An arm whose axes lie as a pattern of `AXES` says, all else random."""
    rng = RNG([seed, *pattern.encode()])
    known = {letter: rng.normal(size=3) for letter in "ab"} | {"p": rng.uniform(-0.5, 0.5, 3)}
    before, joints = np.eye(4), []
    for k, (direction, point) in enumerate(pattern.split()):
        h = known.get(direction, rng.normal(size=3))
        h = h / np.linalg.norm(h) * rng.choice([-1.0, 1.0])
        x = np.cross(h, rng.normal(size=3))
        x /= np.linalg.norm(x)
        frame = np.eye(4)
        frame[:3, :3] = np.column_stack([x, np.cross(h, x), h])
        frame[:3, 3] = known.get(point, rng.uniform(-0.5, 0.5, 3)) + 0.2 * rng.normal() * h
        joints.append(Joint(f"j{k}", "revolute", constant_transform(np.linalg.inv(before) @ frame)))
        before = frame
    tool = np.eye(4)
    tool[:3, :3], tool[:3, 3] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix(), rng.uniform(-0.3, 0.3, 3)
    return ArmModel("axes", tuple(joints), tool=constant_transform(tool))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("pattern", AXES.values(), ids=AXES)
def test_the_joints_behind_a_pose_are_a_branch(pattern, seed):
    model = random_axes(pattern, seed)
    rng = RNG(seed)
    for _ in range(8):
        q0 = rng.uniform(-3.0, 3.0, len(model.joints))
        T = fk(model, q0)
        q, status = solve(model, T)
        reached = status != IkStatus.UNREACHABLE
        assert apart(model, q[reached], q0).min() < 1e-6
        assert max(miss(model, one, T) for one in q[reached]) < 1e-8


def test_five_joints_do_not_reach_any_pose():
    model = random_axes(AXES["five, 2 || 3 || 4"], 0)
    T = fk(model, RNG(0).uniform(-3.0, 3.0, 5))
    T[:3, :3] = T[:3, :3] @ Rotation.from_rotvec([0.1, -0.2, 0.3]).as_matrix()
    assert (solve(model, T)[1] == IkStatus.UNREACHABLE).all()


# --- trees ------------------------------------------------------------------------------------------------------------


def finger(name, parent, mimic=None):
    place = np.array([[1, 0, 0, 0.02], [0, 0, -1, 0], [0, 1, 0, 0.1], [0, 0, 0, 1.0]])
    limits = JointLimits(0.0, 0.04)
    return Joint(name, "prismatic", constant_transform(place), parent=parent, limits=limits, mimic=mimic)


@pytest.fixture(scope="module")
def with_gripper():
    """A UR5e that carries a gripper of two fingers, one of which follows the other; the tool is at its flange."""
    arm = preset("ur5e")
    return Arm(
        dataclasses.replace(
            arm, joints=(*arm.joints, finger("left", 5), finger("right", 5, Mimic(6))), tip=5, bodies=None
        )
    )


def test_a_gripper_leaves_the_arm_its_closed_form(with_gripper):
    q = RNG(0).uniform(-3.0, 3.0, (60, 7))
    q[:, 6] = 0.03
    T = with_gripper.fk(q)
    assert with_gripper.closed_form.family == "three parallel axes"
    found = with_gripper.ik(T)
    assert found.q.shape == (60, 8, 7)
    assert (found.q[..., 6] == 0.0).all()
    assert (with_gripper.ik(T, q).q[..., 6] == 0.03).all()
    reached = found.status != IkStatus.UNREACHABLE
    assert np.abs(with_gripper.fk(found.q) - T[:, None]).max((-1, -2))[reached].max() < 1e-8
    near = with_gripper.ik_nearest(T, q + 1e-3)
    np.testing.assert_allclose(near.q[:, :6], q[:, :6], atol=1e-6)
    np.testing.assert_allclose(near.q[:, 6], q[:, 6] + 1e-3)
    one = with_gripper.ik_nearest(T[3], q[3], weights=np.ones(7))
    np.testing.assert_allclose(one.q, q[3], atol=1e-6)
    with pytest.raises(ShapeError, match=r"q0 .* does not go with"):
        with_gripper.ik(T, q[:3])


def test_a_path_leaves_the_gripper_as_it_is(with_gripper):
    q = np.array([0.2, -1.0, 1.2, 0.3, 0.8, 0.1, 0.03]) + np.linspace(0.0, 0.4, 40)[:, None] * [1, 1, -1, 1, 1, -1, 0]
    found = follow(with_gripper, with_gripper.fk(q), q[0])
    assert found.feasible, found.reason
    np.testing.assert_allclose(found.q, q, atol=1e-6)


def test_a_tree_that_stands_elsewhere_keeps_its_closed_form(with_gripper):
    base = np.eye(4)
    base[:3, 3] = 1.0, 2.0, 0.5
    placed = with_gripper.with_base(base)
    q = RNG(1).uniform(-3.0, 3.0, (10, 7))
    q[:, 6] = 0.01
    np.testing.assert_allclose(placed.ik_nearest(placed.fk(q), q).q, q, atol=1e-6)


def test_what_hangs_beside_the_way_to_the_tool():
    """A cover that follows joint 2 and is carried by link 1 changes nothing but joint 2's limits."""
    puma = preset("puma560")
    cover = Joint("cover", "revolute", parent=0, mimic=Mimic(1, -1.0, 0.0), limits=JointLimits(-0.3, 0.4))
    model = dataclasses.replace(puma, joints=(*puma.joints, cover), tip=5, bodies=None)
    chain = tool_chain(model)
    assert chain.places == (0, 1, 2, 3, 4, 5)
    form = closed_form(chain.model)
    assert (form.family, len(form.names)) == ("spherical wrist", 8)
    assert (chain.model.joints[1].limits.lower, chain.model.joints[1].limits.upper) == (-0.4, 0.3)
    assert tool_chain(puma) is None
    follower = dataclasses.replace(puma.joints[5], mimic=Mimic(3))
    led = dataclasses.replace(puma, joints=(*puma.joints[:5], follower, cover), tip=5, bodies=None)
    assert tool_chain(led) is None


# --- calibrated arms --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["ur5e", "puma560"])
def test_a_calibrated_arm_has_all_branches_of_the_nominal_one(name):
    arm, nominal = calibrated(name, 1), Arm(preset(name))
    assert arm.closed_form.family == nominal.closed_form.family
    assert 5e-4 < arm.closed_form.chain.departure < 1e-2
    rng = RNG(7)
    q = rng.uniform(np.maximum(arm.limits.lower, -3.0), np.minimum(arm.limits.upper, 3.0), (250, 6))
    T = arm.fk(q)
    found = arm.ik(T)
    reached = found.status != IkStatus.UNREACHABLE
    assert np.abs(arm.fk(found.q) - T[:, None]).max((-1, -2))[reached].max() < 1e-9
    home = np.where(reached, apart(arm.model, found.q, q[:, None]), 9.0).min(-1)
    assert (home < 1e-6).mean() > 0.99  # where branches meet, a nominal arm's may be none
    assert found.solutions.mean() > 0.98 * nominal.ik(nominal.fk(q)).solutions.mean()
    np.testing.assert_allclose(arm.ik_nearest(T, q).q, q, atol=1e-6)


def test_an_arm_is_calibrated_and_no_other_arm():
    assert form_of(calibrated("ur5e", 1, rotation=1e-5, shift=1e-6).model).chain.departure < 1e-3
    assert closed_form(calibrated("ur5e", 1, rotation=0.1, shift=0.05).model) is None


@pytest.mark.oracle
@pytest.mark.parametrize(
    "name",
    ["five, 4 meets 5", "five, 2 || 3 || 4", "five, 1 || 2 || 3", "five, 1, 2, 3 meet"],
)
def test_the_same_solutions_as_eaik(name):
    """EAIK (Ostermeier, Külz & Althoff 2024) solves these families too: what it finds is among our branches.

    Of random arms with a skew wrist it finds no solution, so it says nothing about them.
    """
    eaik = pytest.importorskip("eaik.IK_HP", reason="EAIK is not installed (extra 'oracle')")
    model = random_axes(AXES[name], 1)
    peer, R_home = eaik_robot(eaik, model)
    rng, compared = RNG(15), 0
    for _ in range(15):
        T = fk(model, rng.uniform(-3.0, 3.0, len(model.joints)))
        asked = T.copy()
        asked[:3, :3] = T[:3, :3] @ R_home.T
        theirs = [q for q in peer.IK(asked).Q if miss(model, q, T) < 1e-6]
        q, status = solve(model, T)
        ours = q[status != IkStatus.UNREACHABLE]
        assert all(apart(model, ours, row).min() < 1e-5 for row in theirs)
        compared += len(theirs)
    assert compared >= 10
