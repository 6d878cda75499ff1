"""The branch of a closed-form inverse that is nearest to given joints."""

import numpy as np
import pytest
from closed_form_arms import three_joint

from holonom.errors import InputError, NotAPose, ShapeError
from holonom.mechanics import IkStatus, arm_from_dh, load_arm
from holonom.model import LIMIT_TOLERANCE, DHRow


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_rows_and_threads_of_the_nearest_branch(threads):
    """As one by one; and the row of a target that is no pose is counted from the first."""
    arm = load_arm("puma560")
    rng = np.random.default_rng(11)
    q = rng.uniform(arm.limits.lower, arm.limits.upper, (2500, arm.n))
    T, q0 = arm.fk(q), q + rng.normal(0.0, 0.1, q.shape)
    found = arm.ik_nearest(T, q0, threads=threads)
    for k in range(0, 2500, 97):
        one = arm.ik_nearest(T[k], q0[k])
        np.testing.assert_allclose(found.q[k], one.q, rtol=0.0, atol=1e-12)
        assert (found.status[k], found.branch[k]) == (one.status, one.branch)
    T[2100, 0, 0] += 0.3
    for verb in (arm.ik, lambda T, threads: arm.ik_nearest(T, q0, threads=threads)):
        with pytest.raises(NotAPose, match=r"no rotation .*in pose \(2100,\)"):
            verb(T, threads=threads)
    for target, start in ((T[0], q0[0]), (T, q0)):
        with pytest.raises(InputError, match="threads is 0"):
            arm.ik_nearest(target, start, threads=0)


def nearest_by_hand(arm, T, q0, weights):
    """As `Arm.ik_nearest` says it, with NumPy, free joints aside: all whole turns within the limits are tried."""
    found = arm.ik(T)
    turns = np.array([2.0 * np.pi * (joint.kind == "revolute") for joint in arm.model.joints])
    turned = found.q + turns * np.arange(-4, 5).reshape(-1, *[1] * found.q.ndim)
    inside = (turned >= arm.limits.lower - LIMIT_TOLERANCE) & (turned <= arm.limits.upper + LIMIT_TOLERANCE)
    away = np.where(inside, np.abs(turned - q0[..., None, :]), np.inf)
    best = np.take_along_axis(turned, away.argmin(0)[None], 0)[0]
    q = np.where(inside.any(0), best, found.q)
    rank = np.array([0.0, 2e6, 1e6, 0.0])[found.status]
    branch = np.argmin((weights * np.abs(q - q0[..., None, :])).max(-1) + rank, axis=-1)
    taken = np.take_along_axis(q, branch[..., None, None], -2)[..., 0, :]
    return taken, np.take_along_axis(found.status, branch[..., None], -1)[..., 0], branch


@pytest.mark.parametrize("name", ["puma560", "ur5e", "stanford", "scara", "three_joint"])
def test_the_nearest_branch_is_the_one_that_is_defined_so(name):
    arm = load_arm(name)
    rng = np.random.default_rng(18)
    low, high = np.clip(arm.limits.lower, -7.0, None), np.clip(arm.limits.upper, None, 7.0)
    T = arm.fk(rng.uniform(low, high, (400, arm.n)))
    T[::9, :3, 3] *= 1.3  # some out of reach
    q0 = rng.uniform(2.0 * low, 2.0 * high, (400, arm.n))  # some outside the limits, whole turns away
    weights = rng.uniform(0.0, 2.0, arm.n)
    near = arm.ik_nearest(T, q0, weights=weights)
    q, status, branch = nearest_by_hand(arm, T, q0, weights)
    assert len(set(branch.tolist())) == len(near.names)
    np.testing.assert_array_equal(near.branch, branch)
    np.testing.assert_array_equal(near.status, status)
    free = status == IkStatus.SINGULAR
    np.testing.assert_allclose(near.q[~free], q[~free], rtol=0.0, atol=1e-15)
    for k in range(60):
        one = arm.ik_nearest(T[k], q0[k], weights=weights)
        np.testing.assert_allclose(one.q, near.q[k], rtol=0.0, atol=1e-9)
        assert (one.status, one.branch) == (near.status[k], near.branch[k])
        assert one.status.dtype == np.int8
    shared = arm.ik_nearest(T[0], q0[:5])
    np.testing.assert_array_equal(shared.q, arm.ik_nearest(np.array([T[0]] * 5), q0[:5]).q)
    one_start = arm.ik_nearest(T[:6].reshape(2, 3, 4, 4), q0[0])
    assert one_start.q.shape == (2, 3, arm.n)
    assert one_start.status.shape == one_start.branch.shape == (2, 3)


def test_nearest_names_what_is_wrong_with_the_start():
    arm = load_arm("puma560")
    q0 = np.array([0.2, 0.7, -2.9, 0.3, 0.6, -0.4])
    T = arm.fk(q0)
    spoilt = np.where(np.arange(6) == 3, np.nan, q0)
    for start in (spoilt, spoilt.tolist()):
        with pytest.raises(ShapeError, match=rf"q0\[3\] \(joint '{arm.limits.names[3]}'\) is nan; finite"):
            arm.ik_nearest(T, start)
    with pytest.raises(ShapeError, match=r"q0\[3\] .* is nan in row \(1,\)"):
        arm.ik_nearest(T, [q0, spoilt])
    with pytest.raises(ShapeError, match="q0 holds complex"):
        arm.ik_nearest(T, q0 + 0j)
    with pytest.raises(ShapeError, match="not a number"):
        arm.ik_nearest(T, ["a"] * 6)
    for shape in ((2, 8), (8, 2), (1, 16), (16, 1), (16,), (3,), (3, 4)):
        with pytest.raises(NotAPose, match="shape"):
            arm.ik_nearest(np.resize(T, shape), q0)
    with pytest.raises(ShapeError, match="does not go with T"):
        arm.ik_nearest(np.array([T] * 3), [q0] * 2)
    for weights in ([1.0], -np.ones(6), np.full(6, np.nan), np.full(6, np.inf)):
        with pytest.raises(ShapeError, match="weights must be 6"):
            arm.ik_nearest(T, q0, weights=weights)


def test_a_free_joint_of_an_arm_that_places_points_stays_where_it_was():
    arm = three_joint()
    q0 = np.array([0.7, 1.2, 0.6])
    above = np.array([0.0, 0.0, 0.55])  # on the axis of joint 1
    for start in (q0, np.array([q0, q0])):
        near = arm.ik_nearest(above, start)
        assert (near.status == IkStatus.SINGULAR).all()
        np.testing.assert_allclose(near.q[..., 0], 0.7, atol=1e-9)
        np.testing.assert_allclose(
            arm.fk(near.q)[..., :3, 3], np.broadcast_to(above, (*start.shape[:-1], 3)), atol=1e-8
        )


def test_nearest_counts_weights_and_leaves_slides_alone():
    arm = load_arm("stanford")
    q0 = np.array([0.2, 0.8, 0.4, 0.3, 0.6, -0.4])
    near = arm.ik_nearest(arm.fk(q0), q0)
    np.testing.assert_allclose(near.q, q0, atol=1e-9)
    two = arm_from_dh([DHRow(a=0.3), DHRow(a=0.3)], convention="standard", name="p2")
    point = two.fk([0.0, 1.0])[:3, 3]  # the other elbow is (1, -1)
    assert two.ik_nearest(point, [0.9, 0.5]).q[1] == pytest.approx(1.0)
    assert two.ik_nearest(point, [0.9, 0.5], weights=[1.0, 0.0]).q[1] == pytest.approx(-1.0)
    with pytest.raises(ShapeError, match="weights"):
        two.ik_nearest(point, [0.9, 0.5], weights=[1.0])
