"""Numerical inverse kinematics, joint rates and path following: laws on any arm, then peers."""

from __future__ import annotations

import numpy as np
import pytest
from arms import random_model, random_pose, random_tree
from scipy.spatial.transform import Rotation

from holonom import arm_from_dh, load_arm
from holonom.errors import InputError, ModelError, NotAPose, OutOfLimits, ShapeError, UnknownName
from holonom.mechanics import Arm
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.criteria import CRITERIA
from holonom.mechanics.equations.pose_task import damped_multipliers, pose_error, pose_task, rotation_vector
from holonom.mechanics.kernels.pose import multipliers_kernel
from holonom.mechanics.numerical_inverse import InverseStatus, solve_inverse
from holonom.mechanics.velocity import follow_path, joint_rates
from holonom.model import DHRow, JointLimits


def as_pose(T):
    return T[:3, :3].tolist(), T[:3, 3].tolist()


def inside(arm: Arm, q: np.ndarray, margin: float = 0.02) -> np.ndarray:
    """Joint vectors spread over the limits, given numbers in [0, 1)."""
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    return lower + (margin + (1.0 - 2.0 * margin) * q) * (upper - lower)


def apart(arm: Arm, q: np.ndarray, T: np.ndarray) -> np.ndarray:
    """Length of the pose error, by SciPy's logarithm."""
    found = arm.fk(q)
    turn = Rotation.from_matrix((T[..., :3, :3] @ np.swapaxes(found[..., :3, :3], -1, -2)).reshape(-1, 3, 3))
    off = (T[..., :3, 3] - found[..., :3, 3]).reshape(-1, 3)
    return np.linalg.norm(np.hstack([off, turn.as_rotvec()]), axis=1).reshape(T.shape[:-2])


# the task's equations, on floats


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1.0, 2.5, np.pi - 1e-4, np.pi - 1e-9])
def test_rotation_vector_is_accurate_at_any_angle(angle):
    rng = np.random.default_rng(int(1e3 * angle))
    for axis in (*np.eye(3), *rng.normal(size=(20, 3))):
        v = angle * axis / np.linalg.norm(axis)
        np.testing.assert_allclose(rotation_vector(Rotation.from_rotvec(v).as_matrix().tolist()), v, atol=2e-15)


@pytest.mark.parametrize("frame", ["world", "tool"])
@pytest.mark.parametrize("seed", range(6))
def test_exact_jacobian_is_the_derivative_of_the_error(seed, frame):
    model = random_tree(seed, 6) if seed % 2 else random_model(seed, 5)
    n, rng = len(model.independent), np.random.default_rng(seed)
    q, goal, weights = rng.uniform(-2, 2, n), random_pose(rng)[:3].ravel().tolist(), [1.0, 2.0, 0.0, 0.5, 1.0, 3.0]

    def error(x):
        return np.array(pose_task(model, x.tolist(), goal, weights, frame, True)[1:7])

    rows = np.array(pose_task(model, q.tolist(), goal, weights, frame, True)[7 : 7 + 6 * n]).reshape(n, 6)
    for k in range(n):
        h = 1e-6 * np.eye(n)[k]
        np.testing.assert_allclose(rows[k], -(error(q + h) - error(q - h)) / 2e-6, atol=2e-8)


def test_without_weights_the_geometric_jacobian_gives_the_exact_slope():
    model, rng = random_model(3, 6), np.random.default_rng(3)
    q, goal = rng.uniform(-2, 2, 6).tolist(), random_pose(rng)[:3].ravel().tolist()
    weights = [0.3] * 3 + [1.0] * 3
    plain, exact = (np.array(pose_task(model, q, goal, weights, "world", e)) for e in (False, True))
    slopes = [task[7:43].reshape(6, 6) @ task[1:7] for task in (plain, exact)]
    np.testing.assert_allclose(*slopes, atol=1e-12)
    for task in (plain, exact):
        J = task[7:43].reshape(6, 6).T
        np.testing.assert_allclose(task[43:], (J @ J.T)[np.tril_indices(6)], atol=1e-12)


def test_multipliers_solve_the_damped_normal_equations():
    rng = np.random.default_rng(0)
    for n in (1, 3, 6, 9):
        J, x = rng.normal(size=(6, n)), rng.normal(size=6)
        y = damped_multipliers((J @ J.T)[np.tril_indices(6)].tolist(), x.tolist(), 0.01)
        np.testing.assert_allclose((J @ J.T + 0.01 * np.eye(6)) @ y, x, atol=1e-7)


def test_a_step_leaves_blocked_joints_out():
    from holonom.mechanics.loops.solver import damped_step, scratch

    rng, room = np.random.default_rng(2), scratch(7, 6)
    J, x, free = rng.normal(size=(6, 7)), rng.normal(size=6), np.array([1.0, 0, 1, 1, 0, 1, 1])
    state = np.concatenate([np.zeros(7), J.T.ravel(), (J @ J.T)[np.tril_indices(6)]])
    room.normal[21:27] = x
    damped_step(multipliers_kernel().address, state, free, 0.1, room)
    F = J * free
    np.testing.assert_allclose(room.step, F.T @ np.linalg.solve(F @ F.T + 0.1 * np.eye(6), x), atol=1e-9)


def test_error_in_the_tool_frame_is_that_of_the_world_turned():
    rng = np.random.default_rng(1)
    T, goal = random_pose(rng), random_pose(rng)
    world, tool = (np.ravel(pose_error(as_pose(goal), as_pose(T), f)) for f in ("world", "tool"))
    np.testing.assert_allclose(tool.reshape(2, 3), world.reshape(2, 3) @ T[:3, :3], atol=1e-14)


# the search


@pytest.fixture(scope="module")
def panda() -> Arm:
    return load_arm("panda")


def test_reachable_poses_of_a_redundant_arm_are_solved_within_limits(panda):
    rng = np.random.default_rng(0)
    T = panda.fk(inside(panda, rng.random((4000, 7)), margin=0.0))
    found = solve_inverse(panda, T)
    good = found.status == InverseStatus.OK
    assert good.mean() >= 0.999
    error = apart(panda, found.q, T)
    np.testing.assert_allclose(error, found.residual, atol=1e-13)
    assert (error[good] <= 1e-6 + 1e-13).all()
    assert ((found.q >= panda.limits.lower) & (found.q <= panda.limits.upper)).all()
    assert np.isfinite(found.q).all()


def test_threads_and_shape_change_nothing(panda):
    rng = np.random.default_rng(1)
    T = panda.fk(inside(panda, rng.random((15, 10, 7))))
    one, two = solve_inverse(panda, T), solve_inverse(panda, T, threads=2)
    assert one.q.shape == (15, 10, 7)
    assert one.status.shape == one.residual.shape == one.iterations.shape == (15, 10)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
    single = solve_inverse(panda, T[3, 4])
    np.testing.assert_array_equal(single.q, one.q[3, 4])
    assert single.status.shape == ()
    starts = inside(panda, rng.random((15, 10, 7)), margin=0.1)
    started, alone = solve_inverse(panda, T, starts, threads=2), solve_inverse(panda, T[3, 4], starts[3, 4])
    for a, b in zip(started, alone, strict=True):
        np.testing.assert_array_equal(a[3, 4], b)
    posture = {"criterion": "posture", "preferred": starts[0, 0]}
    for a, b in zip(solve_inverse(panda, T[0], **posture), solve_inverse(panda, T[0, 5], **posture), strict=True):
        np.testing.assert_array_equal(a[5], b)
    assert solve_inverse(panda, np.empty((0, 4, 4))).q.shape == (0, 7)


def test_a_near_start_stays_near_and_costs_a_few_steps(panda):
    rng = np.random.default_rng(2)
    q = inside(panda, rng.random((300, 7)), margin=0.1)
    found = solve_inverse(panda, panda.fk(q + 0.01), q)
    assert (found.status == InverseStatus.OK).all()
    assert np.median(found.iterations) <= 3
    assert np.median(np.abs(found.q - q).max(-1)) < 0.05


def test_an_unreachable_pose_is_said_so(panda):
    T = np.eye(4)
    T[:3, 3] = 3.0, 0.0, 0.0
    found = solve_inverse(panda, T, restarts=20)
    assert found.status != InverseStatus.OK
    assert np.isfinite(found.q).all()
    assert float(found.residual) == pytest.approx(float(apart(panda, found.q, T)), abs=1e-12)
    assert found.residual > 1.5


def test_limits_decide():
    """A planar elbow: with the elbow-up solution forbidden and the other one's shoulder too, only no limits reach."""
    rows = [DHRow(a=1.0), DHRow(a=1.0)]
    arm = arm_from_dh(rows, convention="standard", name="elbow", limits=[JointLimits(-0.5, 0.5), JointLimits(0.0, 1.0)])
    T = arm.fk([0.2, 2.0])
    blocked = solve_inverse(arm, T)
    assert blocked.status == InverseStatus.LIMIT
    assert (blocked.q >= arm.limits.lower).all()
    assert (blocked.q <= arm.limits.upper).all()
    free = solve_inverse(arm, T, limits=False)
    assert free.status == InverseStatus.OK
    np.testing.assert_allclose(np.cos(free.q), np.cos([0.2, 2.0]), atol=1e-5)
    assert solve_inverse(arm, arm.fk([0.2, 0.7])).status == InverseStatus.OK


@pytest.mark.parametrize("model", [random_model(11, 1), random_model(13, 3), random_tree(14, 9), random_model(15, 12)])
def test_any_chain(model):
    arm, rng = Arm(model), np.random.default_rng(4)
    T = np.array([
        np.reshape(kinematics.pose(model, row, None), (4, 4)) for row in rng.uniform(-1.9, 1.9, (40, arm.n)).tolist()
    ])  # fmt: skip
    found = solve_inverse(arm, T)
    assert (found.status == InverseStatus.OK).all()
    for q, wanted in zip(found.q.tolist(), T, strict=True):
        np.testing.assert_allclose(np.reshape(kinematics.pose(model, q, None), (4, 4)), wanted, atol=2e-6)
    assert (np.abs(found.q) <= 2.0).all()


def test_joints_without_limits_and_whole_turns():
    rows = [DHRow(a=0.4), DHRow(a=0.3), DHRow(a=0.2)]
    free = arm_from_dh(rows, convention="standard", name="free3r")
    T = free.fk(np.random.default_rng(5).uniform(-9, 9, (50, 3)))
    assert (solve_inverse(free, T).status == InverseStatus.OK).all()
    wide = arm_from_dh(rows, convention="standard", name="wide3r", limits=[JointLimits(0.0, 6.5)] * 3)
    found = solve_inverse(wide, T, restarts=50)
    assert (found.status == InverseStatus.OK).all()
    assert ((found.q >= 0.0) & (found.q <= 6.5)).all()


def test_position_only_and_a_free_tool_axis():
    arm = Arm(random_model(21, 4))
    rng = np.random.default_rng(6)
    T = arm.fk(rng.uniform(-1.9, 1.9, (60, 4)))
    T[:, :3, :3] = Rotation.random(60, rng=rng).as_matrix()
    found = solve_inverse(arm, T, weights=(1, 1, 1, 0, 0, 0), weights_frame="world")
    assert (found.status == InverseStatus.OK).all()
    assert np.linalg.norm(arm.fk(found.q)[:, :3, 3] - T[:, :3, 3], axis=1).max() <= 1e-6
    puma = load_arm("puma560")
    T = puma.fk(inside(puma, rng.random((60, 6)), margin=0.1))
    turned = T.copy()
    turned[:, :3, :3] = T[:, :3, :3] @ Rotation.from_rotvec(np.outer(rng.uniform(-3, 3, 60), [0, 0, 1])).as_matrix()
    start = np.clip(inside(puma, np.full(6, 0.5)), puma.limits.lower, puma.limits.upper)
    found = solve_inverse(puma, turned, start, weights=(1, 1, 1, 1, 1, 0), weights_frame="tool")
    assert (found.status == InverseStatus.OK).all()
    reached = puma.fk(found.q)
    np.testing.assert_allclose(reached[:, :3, 2:], T[:, :3, 2:], atol=2e-6)
    assert np.abs(reached[:, :3, 0] - turned[:, :3, 0]).max() > 0.1


# redundancy


@pytest.mark.parametrize("name", CRITERIA)
def test_criteria_are_climbed_to_where_the_nullspace_offers_nothing_more(panda, name):
    rng = np.random.default_rng(7)
    T = panda.fk(inside(panda, rng.random((40, 7)), margin=0.2))
    preferred = inside(panda, np.full(7, 0.4))
    plain = solve_inverse(panda, T)
    best = solve_inverse(panda, T, criterion=name, preferred=preferred)
    assert (best.status == InverseStatus.OK).all()
    assert (apart(panda, best.q, T) <= 1e-6 + 1e-12).all()

    def height(q):
        return CRITERIA[name](panda.model, q.tolist(), preferred.tolist())

    gained = np.array([height(b) - height(p) for b, p in zip(best.q, plain.q, strict=True)])
    assert (gained > -1e-9).all()
    assert np.median(gained) > 1e-3
    moved = 0
    for q, J in zip(best.q, panda.jacobian(best.q), strict=True):
        if ((q <= panda.limits.lower) | (q >= panda.limits.upper)).any():
            continue  # a corner: the limits hold the climb
        along = np.linalg.svd(J)[2][-1]
        slope = (height(q + 1e-6 * along) - height(q - 1e-6 * along)) / 2e-6
        assert abs(slope) < 5e-3
        moved += 1
    assert moved >= 10


def test_an_own_criterion_is_a_function_of_scalars(panda):
    def elbow_low(model, q, preferred):
        return -1.0 * (q[3] + 2.0) * (q[3] + 2.0)

    T = panda.fk(inside(panda, np.random.default_rng(8).random((10, 7)), margin=0.25))
    plain, low = solve_inverse(panda, T), solve_inverse(panda, T, criterion=elbow_low)
    assert (low.status == InverseStatus.OK).all()
    assert (np.abs(low.q[:, 3] + 2.0) <= np.abs(plain.q[:, 3] + 2.0) + 1e-9).all()


# rates and paths


@pytest.mark.parametrize("frame", ["world", "tool"])
def test_joint_rates_make_the_twist_with_least_speed(panda, frame):
    rng = np.random.default_rng(9)
    q, twist = inside(panda, rng.random((30, 7)), margin=0.2), rng.normal(size=(30, 6))
    J = panda.jacobian(q, frame)
    sigma = np.linalg.svd(J, compute_uv=False)
    good = sigma[:, -1] > 0.03 * sigma[:, 0]
    qd = joint_rates(panda, q, twist, frame=frame)
    assert good.sum() > 10
    np.testing.assert_allclose(np.einsum("kij,kj->ki", J, qd)[good], twist[good], atol=1e-12)
    np.testing.assert_allclose(qd[good], np.einsum("kij,kj->ki", np.linalg.pinv(J), twist)[good], atol=1e-10)
    damped = joint_rates(panda, q[0], twist[0], frame=frame, damping=0.1)
    np.testing.assert_allclose(damped, J[0].T @ np.linalg.solve(J[0] @ J[0].T + 0.01 * np.eye(6), twist[0]), atol=1e-12)


def test_rates_stay_bounded_through_a_singularity():
    arm = load_arm("puma560")
    wrist = np.linspace(-0.2, 0.2, 401)
    q = np.tile([0.3, 0.5, -2.5, 0.4, 0.0, 0.2], (401, 1))
    q[:, 4] = wrist
    lost = np.linalg.svd(arm.jacobian(q[200]))[0][:, -1]
    qd = joint_rates(arm, q, lost)
    bound = 1.0 / (0.02 * np.linalg.svd(arm.jacobian(q), compute_uv=False)[:, 0])
    assert (np.linalg.norm(qd, axis=-1) <= bound + 1e-9).all()
    assert np.abs(joint_rates(arm, q[199], lost, damping=0)).max() > 5 * np.abs(qd).max()


def circle(T, count, radius=0.1):
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    path = np.tile(T, (count, 1, 1))
    path[:, 1, 3] += radius * (np.cos(angle) - 1.0)
    path[:, 2, 3] += radius * np.sin(angle)
    path[:, :3, :3] = Rotation.from_rotvec(0.3 * np.outer(np.sin(angle), [1, 0, 0])).as_matrix() @ T[:3, :3]
    return path


def test_path_following_does_not_drift(panda):
    q0 = np.array([0.1, 0.2, -0.1, -1.8, 0.1, 2.0, 0.5])
    path = circle(panda.fk(q0), 801)
    closed, opened = (follow_path(panda, q0, path, 0.005, gain=g) for g in (None, 0.0))
    assert closed.residual.max() < 2e-5
    assert opened.residual[-1] > 5 * closed.residual.max()
    assert closed.within_limits.all()
    np.testing.assert_allclose(closed.q[1:], closed.q[:-1] + 0.005 * closed.qd[:-1], atol=1e-14)
    np.testing.assert_allclose(apart(panda, closed.q, path), closed.residual, atol=1e-12)


def test_an_error_at_the_start_decays_with_the_gain(panda):
    q0 = np.array([0.1, 0.2, -0.1, -1.8, 0.1, 2.0, 0.5])
    still = np.tile(panda.fk(q0 + 0.01), (2, 101, 1, 1))
    found = follow_path(panda, [q0, q0 + 0.005], still, 0.01, gain=5.0)
    assert found.q.shape == (2, 101, 7)
    expected = found.residual[:, :1] * 0.95 ** np.arange(101)
    np.testing.assert_allclose(found.residual, expected, rtol=0.05, atol=1e-9)


# bad input


def test_bad_input_is_named(panda):
    T, q = panda.fk(inside(panda, np.full(7, 0.5))), inside(panda, np.full(7, 0.5))
    with pytest.raises(NotAPose, match="rotation"):
        solve_inverse(panda, np.diag([1.0, 1.0, 1.1, 1.0]))
    with pytest.raises(ShapeError, match=r"q0 has shape \(1,\); \(\.\.\., 7\)"):
        solve_inverse(panda, T, [0.0])
    spoilt = np.where(np.arange(7) == 2, np.nan, q)
    for start in (spoilt, spoilt.tolist()):
        with pytest.raises(ShapeError, match=rf"q0\[2\] \(joint '{panda.limits.names[2]}'\) is nan"):
            solve_inverse(panda, T, start)
    with pytest.raises(ShapeError, match=r"q0\[2\] .* is nan in row \(1,\)"):
        solve_inverse(panda, T, [q, spoilt])
    with pytest.raises(ShapeError, match="goes with the poses' \\(\\)"):
        solve_inverse(panda, T, [q, q])
    with pytest.raises(ShapeError, match="preferred"):
        solve_inverse(panda, T, q, preferred=spoilt, criterion="posture")
    with pytest.raises(ShapeError, match="q0 holds complex numbers"):
        solve_inverse(panda, T, q + 0j)
    for threads in (0, -1, 1.5, "two"):
        with pytest.raises(InputError, match="threads is"):
            solve_inverse(panda, T, q, threads=threads)
    outside = np.where(np.arange(7) == 3, 1.0, q)
    with pytest.raises(OutOfLimits, match=f"{panda.limits.names[3]}' at 1; .*-3.07"):
        solve_inverse(panda, T, outside)
    assert solve_inverse(panda, T, outside, limits=False).status == InverseStatus.OK
    with pytest.raises(UnknownName, match="manipulability"):
        solve_inverse(panda, T, criterion="manipulabilty")
    with pytest.raises(InputError, match="weights_frame"):
        solve_inverse(panda, T, weights=np.ones(6))
    with pytest.raises(UnknownName, match="tool, world"):
        solve_inverse(panda, T, weights=np.ones(6), weights_frame="base")
    with pytest.raises(ShapeError, match="six numbers"):
        solve_inverse(panda, T, weights=np.zeros(6), weights_frame="tool")
    assert solve_inverse(panda, T, weights=np.ones(6), weights_frame="tool").status == InverseStatus.OK
    with pytest.raises(ShapeError, match="six numbers"):  # also where the same numbers in a row were right before
        solve_inverse(panda, T, weights=np.ones((2, 3)), weights_frame="tool")
    with pytest.raises(InputError, match="tolerance"):
        solve_inverse(panda, T, tolerance=0.0)
    with pytest.raises(InputError, match="restarts"):
        solve_inverse(panda, T, restarts=-1)
    crossed = arm_from_dh([DHRow(a=1.0)], convention="standard", name="crossed", limits=[JointLimits(1.0, -1.0)])
    with pytest.raises(ModelError, match="joint1"):
        solve_inverse(crossed, np.eye(4))
    with pytest.raises(InputError, match="damping"):
        joint_rates(panda, q, np.ones(6), damping="automatic")
    with pytest.raises(ShapeError, match="twist"):
        joint_rates(panda, q, np.ones(5))
    with pytest.raises(InputError, match="gain"):
        follow_path(panda, q, T[None], 0.01, gain=300.0)
    with pytest.raises(ShapeError, match="T_path"):
        follow_path(panda, q, T, 0.01)
    with pytest.raises(InputError, match="dt"):
        follow_path(panda, q, T[None], 0.0)
    with pytest.raises(ShapeError, match="q0"):
        follow_path(panda, q[:3], T[None], 0.01)


@pytest.mark.oracle
def test_solutions_reach_the_poses_in_the_robotics_toolbox(roboticstoolbox):
    """Poses by the peer's forward kinematics of its own Panda, joints by us, poses again by the peer."""
    theirs = roboticstoolbox.models.DH.Panda()
    rows = [DHRow(a=link.a, alpha=link.alpha, d=link.d) for link in theirs.links]
    limits = [JointLimits(*link.qlim) for link in theirs.links]
    arm = arm_from_dh(rows, convention="modified", name="rtb_panda", limits=limits).with_tool(theirs.tool.A)
    rng = np.random.default_rng(10)
    T = np.array([theirs.fkine(q).A for q in inside(arm, rng.random((30, 7)), margin=0.0)])
    found = solve_inverse(arm, T)
    assert (found.status == InverseStatus.OK).all()
    np.testing.assert_allclose([theirs.fkine(q).A for q in found.q], T, atol=2e-6)
