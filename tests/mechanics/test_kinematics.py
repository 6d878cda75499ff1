"""Laws of the geometry: frames, Jacobian, closed-form inverse."""

import json

import numpy as np
import pytest
from arms import presets, random_model, random_tree

from holonom.errors import InputError, NotAPose, ShapeError, UnknownName
from holonom.mechanics import Arm, IkStatus, arm_from_dh, load_arm
from holonom.mechanics.equations import kinematics
from holonom.model import DHRow

ARMS = [*presets(), Arm(random_model(11, 3)), Arm(random_tree(5, 4))]
NAMES = [a.model.name for a in ARMS]


def floats(numbers, *shape):
    return np.array(numbers, dtype=float).reshape(shape)


@pytest.mark.parametrize("arm", ARMS, ids=NAMES)
def test_jacobian_is_the_derivative_of_fk(arm):
    """On the equations as floats, of which the kernels are traced."""
    model, rng = arm.model, np.random.default_rng(3)
    q = rng.uniform(-1.5, 1.5, arm.n)
    J, h = floats(kinematics.jacobian(model, q, "world"), 6, arm.n), 1e-6
    R = floats(kinematics.pose(model, q, None), 4, 4)[:3, :3]
    for k in range(arm.n):
        e = h * np.eye(arm.n)[k]
        ahead, behind = (floats(kinematics.pose(model, x, None), 4, 4) for x in (q + e, q - e))
        W = (ahead - behind)[:3, :3] @ R.T / (2 * h)
        w = np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2
        np.testing.assert_allclose(J[:3, k], (ahead - behind)[:3, 3] / (2 * h), atol=1e-8)
        np.testing.assert_allclose(J[3:, k], w, atol=1e-8)
    turn = np.kron(np.eye(2), R)
    np.testing.assert_allclose(floats(kinematics.jacobian(model, q, "tool"), 6, arm.n), turn.T @ J, atol=1e-12)


@pytest.mark.parametrize("arm", ARMS, ids=NAMES)
def test_frames_are_poses_and_agree(arm):
    model, rng = arm.model, np.random.default_rng(4)
    for q in rng.uniform(-2, 2, (5, arm.n)):
        frames = [floats(kinematics.flat_pose(T), 4, 4) for T in kinematics.frames(model, q)]
        for T in frames:
            np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
        np.testing.assert_array_equal(frames[0], model.base)
        for joint, T in ((None, frames[-1]), (len(model.joints) - 1, frames[-2]), (-1, frames[0])):
            np.testing.assert_allclose(floats(kinematics.pose(model, q, joint), 4, 4), T, atol=1e-13)


@pytest.mark.parametrize("arm", ARMS, ids=NAMES)
def test_compiled_equals_floats(arm):
    """One configuration and rows of them."""
    model, rng = arm.model, np.random.default_rng(5)
    q = rng.uniform(-2, 2, (70, arm.n))
    frames = [floats(kinematics.flat_pose(T), 4, 4) for T in kinematics.frames(model, q[0])]
    last = f"link{len(model.joints)}"
    for name, wanted in (("tool", frames[-1]), (last, frames[-2]), ("base", frames[0])):
        np.testing.assert_allclose(arm.fk(q[0], name), wanted, atol=1e-12)
    np.testing.assert_allclose(arm.frames(q[0]), frames, atol=1e-12)
    np.testing.assert_allclose(arm.frames(q)[:, -1], arm.fk(q), atol=1e-13)
    np.testing.assert_allclose(arm.fk(q)[0], frames[-1], atol=1e-12)
    for frame in ("world", "tool"):
        J = floats(kinematics.jacobian(model, q[0], frame), 6, arm.n)
        np.testing.assert_allclose(arm.jacobian(q[0], frame), J, atol=1e-12)
        np.testing.assert_allclose(arm.jacobian(q, frame)[0], J, atol=1e-12)


@pytest.mark.parametrize("tool", [False, True], ids=["flange", "tool"])
def test_every_branch_of_the_inverse_reaches_the_pose(tool):
    arm = load_arm("puma560")
    if tool:
        T = np.eye(4)
        T[:3, 3] = 0.02, -0.01, 0.15
        arm = arm.with_tool(T).with_base(np.diag([-1.0, -1.0, 1.0, 1.0]))
    rng = np.random.default_rng(5)
    limits = arm.limits
    q = rng.uniform(limits.lower, limits.upper, (3000, 6))
    T = arm.fk(q)
    found = arm.ik(T)
    assert found.names[0] == "righty above noflip"
    reached = found.status != IkStatus.UNREACHABLE
    assert reached.all()
    error = np.abs(arm.fk(found.q) - T[:, None]).max((-1, -2))
    assert error.max() < 1e-11
    own = np.abs((found.q - q[:, None] + np.pi) % (2 * np.pi) - np.pi).max(-1)
    best = own.argmin(-1)
    assert own.min(-1).max() < 1e-8
    assert (np.take_along_axis(found.status, best[:, None], 1) == IkStatus.OK).mean() > 0.999
    inside = ((found.q >= limits.lower - 1e-9) & (found.q <= limits.upper + 1e-9)).all(-1)
    np.testing.assert_array_equal(inside, found.status == IkStatus.OK)


def test_branches_carry_their_names():
    arm = load_arm("puma560")
    found = arm.ik(arm.fk([0.2, 0.7, -2.9, 0.3, 0.6, -0.4]))
    elbow = arm.fk(found.q, frame="link2")[:, :3, 3]
    wrist = arm.fk(found.q, frame="link4")[:, :3, 3]
    shoulder = np.array([0.0, 0.0, 0.67183])
    for name, e, w, q in zip(found.names, elbow, wrist, found.q, strict=True):
        side, height, flip = name.split()
        # above: the elbow lies above the line from shoulder to wrist, seen from the side
        along = (w - shoulder) * np.array([1, 1, 0])
        line = shoulder[2] + (w - shoulder)[2] * (e - shoulder)[:2] @ along[:2] / (along @ along)
        assert (e[2] > line) == (height == "above")
        assert (q[4] >= 0) == (flip == "noflip")
        forward = np.array([np.cos(q[0]), np.sin(q[0])])
        assert (forward @ w[:2] > 0) == (side == "righty")


def test_unreachable_and_singular_are_said_per_branch():
    arm = load_arm("puma560")
    far = np.eye(4)
    far[:3, 3] = 2.0, 0.0, 0.5
    found = arm.ik(far)
    assert (found.status == IkStatus.UNREACHABLE).all()
    assert np.isfinite(found.q).all()
    near_axis = np.eye(4)
    near_axis[:3, 3] = 0.05, 0.05, 0.5
    assert (arm.ik(near_axis).status == IkStatus.UNREACHABLE).all()
    q = np.array([0.3, 0.5, -2.5, 0.4, 0.0, 0.2])
    found = arm.ik(arm.fk(q))
    singular = found.status == IkStatus.SINGULAR
    assert singular.any()
    np.testing.assert_allclose(arm.fk(found.q[singular]), np.broadcast_to(arm.fk(q), (singular.sum(), 4, 4)), atol=1e-9)


def test_nearest_branch_returns_home_and_turns_whole_turns():
    arm = load_arm("puma560")
    rng = np.random.default_rng(6)
    q = rng.uniform(arm.limits.lower, arm.limits.upper, (500, 6))
    q = q[np.abs(q[:, 4]) > 0.05]
    near = arm.ik_nearest(arm.fk(q), q)
    np.testing.assert_allclose(near.q, q, atol=1e-6)
    assert (near.status == IkStatus.OK).all()


def test_at_a_straight_wrist_the_free_joint_stays_where_it_was():
    arm = load_arm("puma560")
    q = np.array([[0.3, 0.5, -2.4, 0.4, 0.0, -0.5], [0.3, 0.5, -2.4, 0.4, 0.3, -0.5]])
    near = arm.ik_nearest(arm.fk(q), q)
    np.testing.assert_allclose(near.q, q, atol=1e-9)
    assert near.status.tolist() == [IkStatus.SINGULAR, IkStatus.OK]


@pytest.mark.oracle
def test_inverse_against_eaik():
    """EAIK's subproblem decomposition finds the same set of solutions."""
    eaik = pytest.importorskip("eaik.IK_DH", reason="EAIK is not installed (extra 'oracle')")
    arm = load_arm("puma560")
    alpha = np.array([0.5, 0.0, -0.5, 0.5, -0.5, 0.0]) * np.pi
    peer = eaik.DhRobot(alpha, np.array([0, 0.4318, 0.0203, 0, 0, 0]), np.array([0.67183, 0, 0.15005, 0.4318, 0, 0]))
    rng = np.random.default_rng(7)
    for q in rng.uniform(-1.5, 1.5, (50, 6)):
        T = arm.fk(q)
        theirs = np.array(peer.IK(T).Q)
        ours = arm.ik(T).q
        apart = np.abs((theirs[:, None] - ours[None] + np.pi) % (2 * np.pi) - np.pi).max(-1)
        assert len(theirs) == 8
        assert apart.min(1).max() < 1e-6


def test_published_puma_geometry(data_folder):
    case = json.loads((data_folder / "robots" / "puma560_cases.json").read_text())
    arm, qn = load_arm("puma560"), case["poses"]["qn"]
    np.testing.assert_allclose(arm.fk(qn), case["python"]["fkine_qn_d1_067183"], atol=1e-4)
    np.testing.assert_allclose(arm.jacobian(qn), case["python"]["jacob0_qn"], atol=1e-4)


def test_modified_convention_gives_the_published_panda(data_folder):
    panda = json.loads((data_folder / "robots" / "puma560_cases.json").read_text())["panda_dh"]
    m = panda["mdh"]
    rows = [DHRow(a=a, alpha=k * np.pi, d=d) for a, k, d in zip(m["a"], m["alpha_over_pi"], m["d"], strict=True)]
    c = np.sqrt(0.5)  # the printed values belong to a tool of 103 mm behind the flange's 107 mm, not to 103.4 mm
    tool = np.array([[c, c, 0, 0], [-c, c, 0, 0], [0, 0, 1, 0.103], [0, 0, 0, 1]])
    arm = arm_from_dh(rows, convention="modified", name="panda_mdh").with_tool(tool)
    np.testing.assert_allclose(arm.fk(panda["q"]), panda["fkine"], atol=1e-4)
    np.testing.assert_allclose(arm.jacobian(panda["q"], frame="tool"), panda["jacobe"], atol=1e-4)


def test_errors_name_the_cause():
    arm = load_arm("puma560")
    with pytest.raises(NotAPose, match="rotation"):
        arm.ik(np.diag([1.0, 1.0, 1.1, 1.0]))
    with pytest.raises(NotAPose, match="shape"):
        arm.ik(np.eye(3))
    with pytest.raises(ShapeError, match="q0"):
        arm.ik_nearest(arm.fk(np.zeros(6)), [0.0])
    with pytest.raises(UnknownName, match="link6"):
        arm.fk(np.zeros(6), frame="link7")
    with pytest.raises(UnknownName, match="standard"):
        arm_from_dh([DHRow()], convention="craig")
    with pytest.raises(InputError, match=r"no closed-form inverse.{,60}; ik_nearest"):
        arm_from_dh([DHRow(a=1.0)], convention="standard").ik(np.eye(4))
