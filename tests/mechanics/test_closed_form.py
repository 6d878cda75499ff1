"""Closed-form inverses: fk(ik(T)) = T on random arms of every family, presets and shipped URDF files."""

import dataclasses

import numpy as np
import pytest
from arms import presets
from closed_form_arms import FAMILIES, apart, backwards, family_model, fk, form_of, miss, solve, three_joint
from peers import eaik_robot
from scipy.spatial.transform import Rotation

from holonom.errors import InputError, NotAPose, ShapeError
from holonom.mechanics import Arm, IkCase, IkStatus, arm_from_dh, load_arm
from holonom.mechanics.equations.inverse.general_arm import quartic_roots
from holonom.mechanics.kernels.inverse.closed_form import closed_form
from holonom.model import DHRow, JointLimits, constant_transform, outside

CLOSED = [arm for arm in presets() if arm.closed_form is not None]
URDFS = {
    "example_robot_data/ur3_robot.urdf": "three parallel axes",
    "example_robot_data/ur5_robot.urdf": "three parallel axes",
    "example_robot_data/ur10_robot.urdf": "three parallel axes",
    "rtb_data/kr210l150.urdf": "spherical wrist",
    "rtb_data/puma560_robot.urdf": "spherical wrist",
}


def _law(model, rng, count, exact=1e-11):
    """Every branch that is said to reach a pose does, and the joints that made it are among them."""
    for _ in range(count):
        q0 = rng.uniform(-2.5, 2.5, len(model.joints))
        T = fk(model, q0)
        q, status = solve(model, T)
        assert np.isfinite(q).all()
        reached = status != IkStatus.UNREACHABLE
        assert max(miss(model, row, T) for row in q[reached]) < exact
        assert apart(model, q[reached], q0).min() < 1e-7


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("family", FAMILIES)
def test_random_arms_of_each_family(family, seed):
    exact = 1e-8 if family.startswith("any") else 1e-11  # roots of a quartic that nearly meet
    _law(family_model(family, seed), np.random.default_rng(seed), 10, exact)


@pytest.mark.parametrize("family", ["2 parallel to 3", "1 meets 2", "three parallel"])
def test_arms_built_the_other_way_round(family):
    model = backwards(family_model(family, 4))
    assert form_of(model).family in ("spherical shoulder", "three parallel axes, backwards")
    _law(model, np.random.default_rng(8), 10)


@pytest.mark.parametrize("file", URDFS)
def test_shipped_urdf_files(file, data_folder):
    model = load_arm(data_folder / "robots" / "urdf" / file).model
    form = form_of(model)
    assert form.family == URDFS[file]
    assert form.exact
    rng = np.random.default_rng(9)
    for _ in range(25):
        q0 = rng.uniform(-2, 2, 6)
        q, status = solve(model, fk(model, q0))
        reached = status != IkStatus.UNREACHABLE
        assert max(miss(model, row, fk(model, q0)) for row in q[reached]) < 1e-8
        assert apart(model, q[reached], q0).min() < 1e-6


@pytest.mark.parametrize("arm", CLOSED, ids=lambda arm: arm.model.name)
def test_presets_in_batches(arm):
    rng = np.random.default_rng(10)
    limits = arm.limits
    span = np.clip(limits.lower, -3.0, None), np.clip(limits.upper, None, 3.0)
    q0 = rng.uniform(*span, (3000, arm.n))
    T = arm.fk(q0)
    found = arm.ik(T)
    reached = found.status != IkStatus.UNREACHABLE
    missed = np.abs(arm.fk(found.q) - T[:, None])
    missed = missed if arm.closed_form.task == "pose" else missed[..., :3, 3:]
    assert missed.max((-1, -2))[reached].max() < 1e-10
    home = np.where(reached, apart(arm.model, found.q, q0[:, None]), 9.0)
    assert home.min(-1).max() < 1e-6
    best = np.take_along_axis(found.status, home.argmin(-1)[:, None], 1)
    assert (best == IkStatus.OK).mean() > 0.999
    inside = ~outside(found.q, limits.lower, limits.upper).any(-1)
    np.testing.assert_array_equal(inside[reached], (found.status != IkStatus.LIMIT)[reached])
    q, status = solve(arm.model, T[7])
    np.testing.assert_allclose(found.q[7], q, atol=1e-12)
    np.testing.assert_array_equal(found.status[7], status)


def straight_wrist(model, parallel):
    """The q5 that lays axis 6 along axis `parallel`."""
    chain = form_of(model).chain
    for turn in (0.0, np.pi / 2):
        along = Rotation.from_rotvec(turn * np.array(chain.screws[4].h)).apply(chain.screws[5].h)
        if np.linalg.norm(np.cross(along, chain.screws[parallel - 1].h)) < 1e-9:
            return chain.reference[4] + turn
    raise AssertionError("the wrist cannot be straight")


@pytest.mark.parametrize(("family", "parallel"), [("2 against 3", 4), ("three parallel, one against", 2)])
def test_nothing_is_lost_close_to_a_straight_wrist(family, parallel):
    model = family_model(family, 2)
    straight = straight_wrist(model, parallel)
    rng = np.random.default_rng(11)
    for bend in 10.0 ** np.arange(-8.5, 0.0, 0.25):
        q0 = rng.uniform(-1.0, 1.0, 6)
        q0[4] = straight + bend
        T = fk(model, q0)
        q, status = solve(model, T)
        reached = status != IkStatus.UNREACHABLE
        assert reached.sum() >= 2
        assert max(miss(model, row, T) for row in q[reached]) < 1e-13
        assert apart(model, q[reached], q0).min() < 1e-14 / bend + 1e-12


def test_a_straight_wrist_is_singular_and_reached():
    model = family_model("2 against 3", 3)
    q0 = np.array([0.3, -0.4, 0.5, 0.6, straight_wrist(model, 4), -0.7])
    T = fk(model, q0)
    q, status = solve(model, T)
    singular = q[status == IkStatus.SINGULAR]
    assert len(singular) >= 2
    assert max(miss(model, row, T) for row in singular) < 1e-13
    assert np.abs(singular[:, 3]).max() < 1e-12


def test_a_ur_with_its_tool_along_the_parallel_axes_is_reached():
    model = load_arm("ur5e").model
    rng = np.random.default_rng(17)
    for _ in range(40):
        q0 = rng.uniform(-2.5, 2.5, 6)
        q0[4] = 0.0
        T = fk(model, q0)
        q, status = solve(model, T)
        singular = q[status == IkStatus.SINGULAR]
        assert len(singular) >= 2
        assert max(miss(model, row, T) for row in singular) < 1e-8


@pytest.mark.parametrize(
    ("point", "solutions", "case"),
    [
        ([0.2, 0.1, 0.45], 4, IkCase.REGULAR),
        ([0.6, 0.3, 0.3], 0, IkCase.OUT_OF_REACH),
        ([0.01, 0.02, 0.3], 0, IkCase.OUT_OF_REACH),  # nearer to the shoulder than |l1 - l2|
        ([0.45, 0.0, 0.3], 2, IkCase.BOUNDARY),
        ([0.0, 0.0, 0.55], -1, IkCase.ON_AXIS),
    ],
)
def test_three_joints_name_each_case(point, solutions, case):
    arm = three_joint()
    assert arm.closed_form.task == "position"
    found = arm.ik(np.array([point, point]))
    np.testing.assert_array_equal(found.solutions, [solutions] * 2)
    np.testing.assert_array_equal(found.case, [case] * 2)
    reached = found.status != IkStatus.UNREACHABLE
    np.testing.assert_allclose(
        arm.fk(found.q)[reached][:, :3, 3], np.broadcast_to(point, (reached.sum(), 3)), atol=1e-8
    )
    T = np.eye(4)
    T[:3, 3] = point
    np.testing.assert_array_equal(arm.ik(T).status, found.status[0])


def test_an_elbow_is_named_as_it_lies():
    arm = three_joint()
    found = arm.ik([0.2, 0.1, 0.45])
    elbow = arm.fk(found.q, frame="link2")[:, :3, 3]
    along = np.hypot(0.2, 0.1)
    side = np.where([name.startswith("front") for name in found.names], 1.0, -1.0)
    forward = elbow[:, :2] @ [0.2, 0.1] / along
    line = 0.3 + 0.15 * forward / along
    np.testing.assert_array_equal(elbow[:, 2] > line, ["above" in name for name in found.names])
    reach = np.cos(found.q[:, 0]) * 0.2 + np.sin(found.q[:, 0]) * 0.1
    np.testing.assert_array_equal(np.sign(reach), side)


def test_turns_are_wrapped_into_the_limits():
    rows = [DHRow(a=0.3), DHRow(a=0.2), DHRow(a=0.1)]
    limits = [JointLimits(5.0, 8.0), JointLimits(-7.0, -3.0), JointLimits(-1.0, np.inf)]
    arm = arm_from_dh(rows, convention="standard", name="p3", limits=limits)
    rng = np.random.default_rng(12)
    q0 = rng.uniform([5.0, -6.0, 3.2], [8.0, -3.3, 5.0], (200, 3))
    found = arm.ik(arm.fk(q0))
    mine = np.abs(found.q - q0[:, None]).max(-1).min(-1)
    assert mine.max() < 1e-9
    assert (found.status == IkStatus.OK).any(-1).all()


def test_planar_arms_refuse_poses_out_of_their_plane():
    arm = arm_from_dh([DHRow(a=0.3), DHRow(a=0.2), DHRow(a=0.1)], convention="standard", name="p3")
    T = arm.fk([0.3, 0.4, 0.5])
    T[2, 3] = 1e-6
    assert (arm.ik(T).status == IkStatus.UNREACHABLE).all()


def test_rotations_are_cleaned_before_use():
    arm = load_arm("puma560")
    q0 = np.array([0.2, 0.7, -2.9, 0.3, 0.6, -0.4])
    T = arm.fk(q0)
    T[:3, :3] += np.random.default_rng(13).uniform(-2e-7, 2e-7, (3, 3))
    found = arm.ik(T)
    assert (found.status == IkStatus.OK).any()
    np.testing.assert_allclose(found.q[apart(arm.model, found.q, q0).argmin()], q0, atol=1e-5)


def test_axes_that_are_only_nearly_parallel_are_refined():
    """A file that writes 1.5708 for pi / 2: the closed form of the arm that was meant, then Newton's method."""
    turns = (1.5708, 0.0, -1.5708, 1.5708, -1.5708, 0.0)
    rows = [
        DHRow(a=a, alpha=alpha, d=d)
        for a, alpha, d in zip((0, 0.43, 0.02, 0, 0, 0), turns, (0.6, 0, 0.15, 0.43, 0, 0.05), strict=True)
    ]
    arm = arm_from_dh(rows, convention="standard", name="nearly")
    assert not arm.closed_form.exact
    q0 = np.random.default_rng(14).uniform(-1.5, 1.5, (60, 6))
    q0 = q0[np.abs(q0[:, 4]) > 0.1]
    T = arm.fk(q0)
    found = arm.ik(T)
    reached = found.status == IkStatus.OK
    assert reached.any(-1).all()
    assert np.abs(arm.fk(found.q) - T[:, None]).max((-1, -2))[reached].max() < 1e-8
    assert np.where(reached, apart(arm.model, found.q, q0[:, None]), 9.0).min(-1).max() < 1e-6


SPOILT = {
    "scaled": lambda T: T * np.array([1.0 + 2e-6] * 3 + [1.0]),
    "scaled much": lambda T: T * np.array([1.1] * 3 + [1.0]),
    "one axis longer": lambda T: T * np.array([1.0, 1.0 + 4e-6, 1.0, 1.0]),
    "sheared": lambda T: T @ (np.eye(4) + 2e-6 * np.eye(4, k=1) * [0, 1, 1, 0]),
    "a mirror": lambda T: T * np.array([1.0, 1.0, -1.0, 1.0]),
    "turned inside out": lambda T: T * np.array([-1.0, -1.0, -1.0, 1.0]),
    "no rotation": lambda T: T * np.array([0.0, 0.0, 0.0, 1.0]),
    "NaN": lambda T: T + np.nan * np.eye(4, k=3),
    "infinite": lambda T: T + np.where(np.eye(4, k=3), np.inf, 0.0),
    "NaN in the rotation": lambda T: np.where(np.eye(4), np.nan, T),
    "bad last row": lambda T: T + 1e-9 * np.eye(4, k=-3),
    "bad corner": lambda T: T * np.where(np.arange(16).reshape(4, 4) == 15, 1.0 + 1e-12, 1.0),
    "NaN in the last row": lambda T: T + np.nan * np.eye(4, k=-3),
    "complex": lambda T: T + 0j,
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT.keys())
@pytest.mark.parametrize("name", ["puma560", "ur5e", "scara"])
def test_what_is_no_pose_is_always_refused(name, spoil):
    """Reachable otherwise: the proof by forward kinematics alone would let a little through."""
    arm = load_arm(name)
    assert arm.closed_form.task == "pose"
    q0 = np.clip(np.full(arm.n, 0.4), arm.limits.lower, arm.limits.upper)
    T = arm.fk(q0)
    bad = spoil(T)
    for asked in (bad, bad.tolist(), np.asfortranarray(bad), np.array([T, bad, T]), np.array([bad])):
        with pytest.raises(NotAPose):
            arm.ik(asked)
        with pytest.raises(NotAPose):
            arm.ik_nearest(asked, q0)
    fine = T * np.array([1.0 + 4e-7, 1.0, 1.0, 1.0])
    assert (arm.ik(fine).status != IkStatus.UNREACHABLE).any()


def test_an_arm_without_closed_form_says_what_to_do():
    panda = load_arm("panda")
    assert panda.closed_form is None
    with pytest.raises(InputError, match=r"no closed-form inverse.*ik_nearest"):
        panda.ik(np.eye(4))
    q0 = np.array([0.1, 0.2, 0.3, -1.5, 0.2, 1.5, 0.4])
    near = panda.ik_nearest(panda.fk(q0), q0 + 0.05)
    assert near.status == IkStatus.OK
    assert near.names == ()
    np.testing.assert_allclose(panda.fk(near.q), panda.fk(q0), atol=1e-5)


def test_offset_wrists_and_trees_have_no_closed_form():
    model = family_model("2 parallel to 3", 1)
    joint = model.joints[4]
    shifted = np.array(joint.after) @ np.array([[1.0, 0, 0, 0.05], [0, 1, 0, 0.03], [0, 0, 1, 0.02], [0, 0, 0, 1]])
    joints = [*model.joints[:4], dataclasses.replace(joint, after=constant_transform(shifted)), model.joints[5]]
    assert closed_form(dataclasses.replace(model, joints=tuple(joints))) is None
    assert closed_form(dataclasses.replace(model, tip=4)) is None


def test_points_are_checked():
    arm = three_joint()
    with pytest.raises(NotAPose, match="shape"):
        arm.ik(np.zeros((2, 2)))
    with pytest.raises(ShapeError, match="nan"):
        arm.ik([np.nan, 0.0, 0.0])


def determinants(model, q):
    """Of the Jacobian of the tool's place, of a three-joint arm."""
    return np.linalg.det(Arm(model).jacobian(q)[..., :3, :])


@pytest.mark.parametrize("seed", range(4))
def test_names_of_the_quartic_say_the_sign_of_the_determinant_and_the_order_of_q3(seed):
    model = family_model("any three joints", seed)
    arm, form = Arm(model), form_of(model)
    q0 = np.random.default_rng(seed).uniform(-3, 3, (1000, 3))
    found = arm.ik(arm.fk(q0)[:, :3, 3])
    assert found.names == ("det+ first", "det+ second", "det- first", "det- second")
    reached, determinant = found.status != IkStatus.UNREACHABLE, determinants(model, found.q)
    simple = np.abs(np.where(reached, determinant, 1.0)).min(-1) > 1e-4
    assert simple.mean() > 0.95
    reached, determinant, q = reached[simple], determinant[simple], found.q[simple]
    assert (determinant[:, :2][reached[:, :2]] > 0.0).all()
    assert (determinant[:, 2:][reached[:, 2:]] < 0.0).all()
    np.testing.assert_array_equal(reached[:, :2], reached[:, 2:])  # as many of the one as of the other
    assert (reached[:, 0] | ~reached[:, 1]).all()  # the first before the second
    assert 0 < reached[:, 1].sum() < len(reached)
    third = (q[:, :, 2] - form.chain.reference[2] + np.pi) % (2 * np.pi) - np.pi
    four = reached.all(-1)
    assert (third[four, 0] < third[four, 1]).all()
    assert (third[four, 2] < third[four, 3]).all()
    twice = apart(model, q[:, :, None], q[:, None]) + np.where(np.eye(4, dtype=bool), 9.0, 0.0)
    assert twice[four].min() > 1e-6  # no root is found twice


@pytest.mark.parametrize("seed", range(3))
def test_names_of_the_quartic_last(seed):
    """A branch keeps its sign up to a singularity, its number while none is born, ends or passes the cut."""
    model = family_model("any three joints", seed)
    arm = Arm(model)
    rng = np.random.default_rng(seed)
    way = rng.uniform(-2, 2, 3) + np.sin(np.linspace(0.0, 5.0, 4000)[:, None] * rng.uniform(0.5, 1.5, 3)) * 1.5
    found = arm.ik(arm.fk(way)[:, :3, 3])
    reached = found.status != IkStatus.UNREACHABLE
    at = np.where(reached, apart(model, found.q, way[:, None]), 9.0).argmin(-1)
    determinant = determinants(model, way)
    clear = np.abs(determinant) > 1e-4
    np.testing.assert_array_equal((at < 2)[clear], determinant[clear] > 0.0)
    steps = np.flatnonzero(at[1:] != at[:-1])
    assert 0 < len(steps) < 40
    third = (found.q[..., 2] - form_of(model).chain.reference[2] + np.pi) % (2 * np.pi) - np.pi
    for i in steps:
        born = (reached[i] != reached[i + 1]).any()
        singular = determinant[i] * determinant[i + 1] <= 0.0 or not clear[i] or not clear[i + 1]
        cut = (np.abs(third[i, reached[i]]) > np.pi - 0.05).any()
        assert born or singular or cut


def real_roots(*coefficients):
    return np.sort([root for root, imaginary in quartic_roots(*coefficients) if imaginary == 0.0])


def test_quartic_roots():
    rng = np.random.default_rng(16)
    for _ in range(100):
        roots = np.sort(rng.uniform(-3, 3, 4))
        apart_ = np.diff(roots).min()
        found = np.sort([root for root, _ in quartic_roots(*np.poly(roots)[1:].tolist())])
        np.testing.assert_allclose(found, roots, atol=1e-12 / min(apart_, 1.0) ** 3)
    np.testing.assert_allclose(real_roots(0.0, -5.0, 0.0, 4.0), [-2.0, -1.0, 1.0, 2.0], atol=1e-14)
    np.testing.assert_allclose(real_roots(0.0, 0.0, 0.0, -1.0), [-1.0, 1.0], atol=1e-14)
    pair = [found for found in quartic_roots(*np.poly([1.0, 2.0, -1.0 + 2.0j, -1.0 - 2.0j]).real[1:]) if found[1] > 0.0]
    np.testing.assert_allclose(pair, [(-1.0, 2.0)] * 2, atol=1e-12)


@pytest.mark.oracle
@pytest.mark.parametrize(
    "name",
    [
        "puma560",
        "ur5e",
        "2 parallel to 3",
        "1 parallel to 2",
        "1 meets 2",
        "2 meets 3",
        "any spherical wrist",
        "three parallel",
    ],
)
def test_the_same_solutions_as_eaik(name):
    """EAIK (Ostermeier, Külz & Althoff 2024) finds the same joints, each of which reaches the pose."""
    eaik = pytest.importorskip("eaik.IK_HP", reason="EAIK is not installed (extra 'oracle')")
    model = family_model(name, 5) if name in FAMILIES else load_arm(name).model
    peer, R_home = eaik_robot(eaik, model)
    rng = np.random.default_rng(15)
    compared = 0
    for _ in range(25):
        q0 = rng.uniform(-1.5, 1.5, 6)
        T = fk(model, q0)
        asked = T.copy()
        asked[:3, :3] = T[:3, :3] @ R_home.T
        theirs = np.array([q for q in peer.IK(asked).Q if miss(model, q, T) < 1e-6])
        q, status = solve(model, T)
        ours = q[status != IkStatus.UNREACHABLE]
        assert all(apart(model, ours, row).min() < 1e-5 for row in theirs)
        if name != "any spherical wrist":  # there it searches, and misses some
            assert all(apart(model, theirs, row).min() < 1e-5 for row in ours)
        compared += len(theirs)
    assert compared >= 50
