"""Laws of differential motion and statics."""

import numpy as np
import pytest
from arms import random_model

from holonom.errors import OutOfLimits, ShapeError, UnknownName
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.analysis import (
    force_ellipsoid,
    joint_torques,
    largest_force,
    lost_directions,
    manipulability,
    nullspace,
    singular_values,
    singularities,
    transform_twist,
    transform_wrench,
    velocity_ellipsoid,
)
from holonom.mechanics.velocity import joint_rates

Q = np.array([0.3, 0.5, -2.4, 0.4, 0.6, -0.2])


@pytest.fixture(scope="module")
def arm():
    return load_arm("puma560")


def test_manipulability_is_the_root_of_the_determinant(arm):
    q = np.tile(Q, (4, 1)) + 0.1 * np.arange(4)[:, None]
    J = arm.jacobian(q)
    np.testing.assert_allclose(manipulability(arm, q), np.sqrt(np.linalg.det(J @ np.swapaxes(J, 1, 2))), rtol=1e-9)
    np.testing.assert_allclose(singular_values(arm, Q), np.linalg.svd(arm.jacobian(Q))[1])


def test_ellipsoids_hold_every_direction(arm):
    rng = np.random.default_rng(1)
    J = arm.jacobian(Q)[:3]
    ellipsoid = velocity_ellipsoid(arm, Q)
    rates = rng.normal(size=(2000, 6))
    v = (rates / np.linalg.norm(rates, axis=1, keepdims=True)) @ J.T
    inside = np.sum((v @ ellipsoid.axes / ellipsoid.radii) ** 2, axis=1)
    assert inside.max() <= 1.0 + 1e-12
    assert np.linalg.norm(J @ np.linalg.pinv(J)[:, :] @ ellipsoid.axes[:, 0]) == pytest.approx(1.0)
    force = force_ellipsoid(arm, Q)
    for axis, radius in zip(force.axes.T, force.radii, strict=True):
        assert np.linalg.norm(J.T @ (axis * radius)) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("name", "q"),
    [
        ("wrist", [0.3, 0.5, -2.4, 0.4, 0.0, -0.2]),
        ("elbow", [0.3, 0.5, -np.arctan2(0.4318, 0.0203) + np.pi, 0.4, 0.6, -0.2]),
        ("shoulder", None),
    ],
)
def test_named_singularities_lose_one_direction(arm, name, q):
    if q is None:  # the wrist centre over the shoulder: solve a2 c2 + a3 c23 - d4 s23 = 0 for q2
        q3 = -2.4
        a = 0.4318 + 0.0203 * np.cos(q3) - 0.4318 * np.sin(q3)
        b = -0.0203 * np.sin(q3) - 0.4318 * np.cos(q3)
        q = [0.3, np.arctan2(-a, b), q3, 0.4, 0.6, -0.2]
    found = {s.name: s for s in singularities(arm, q)}
    assert found[name].near
    assert abs(found[name].value) < 1e-12
    lost = lost_directions(arm, q)
    assert lost.shape == (1, 6)
    np.testing.assert_allclose(lost @ arm.jacobian(q), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.abs(lost[0] @ found[name].direction), 1.0)
    assert not any(s.near for s in singularities(arm, Q))
    assert nullspace(arm, q).shape == (6, 1)
    np.testing.assert_allclose(arm.jacobian(q) @ nullspace(arm, q), 0.0, atol=1e-12)


def test_the_three_singularities_of_a_ur():
    q = (0.4, -1.1, 1.3, -0.6, 0.9, 0.2)
    arm = load_arm("ur5e")
    assert not any(s.near for s in singularities(arm, q))
    for name, joint, value in (("elbow", 2, 0.0), ("wrist", 4, 0.0)):
        at = list(q)
        at[joint] = value
        nearest = singularities(arm, at)[0]
        assert nearest.name == name
        assert abs(nearest.value) < 1e-9
        np.testing.assert_allclose(nearest.direction @ arm.jacobian(at), 0.0, atol=1e-9)
    low, high = -1.1, 0.9  # the shoulder's: a sign change of its measure along joint 2, found by bisection
    measure = lambda q2: {s.name: s.value for s in singularities(arm, [q[0], q2, *q[2:]])}["shoulder"]  # noqa: E731
    assert measure(low) * measure(high) < 0.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if measure(low) * measure(middle) > 0.0 else (low, middle)
    assert singular_values(arm, [q[0], low, *q[2:]])[-1] < 1e-9


def test_power_does_not_depend_on_the_frame(arm):
    rng = np.random.default_rng(2)
    h, qd = rng.normal(size=6), rng.normal(size=6)
    T = arm.fk(Q)
    for frame in ("world", "base", "tool"):
        twist = arm.jacobian(Q, frame=frame) @ qd
        assert joint_torques(arm, Q, h, frame) @ qd == pytest.approx(h @ twist)
    t_tool = arm.jacobian(Q, frame="tool") @ qd
    h_world, t_world = transform_wrench(T, h), transform_twist(T, t_tool)
    assert h_world @ t_world == pytest.approx(h @ t_tool)
    np.testing.assert_allclose(t_world[3:], (arm.jacobian(Q) @ qd)[3:], atol=1e-12)


def test_the_largest_force_uses_up_one_joint(arm):
    for d in ([1.0, 0.0, 0.0], [0.0, 0.0, -2.0], [0.3, -0.4, 0.5]):
        force = largest_force(arm, Q, d)
        unit = np.array(d) / np.linalg.norm(d)
        tau = arm.gravity(Q) + joint_torques(arm, Q, [*(force * unit), 0.0, 0.0, 0.0])
        assert (np.abs(tau) / arm.limits.torque).max() == pytest.approx(1.0)


def test_generic_arms_and_bad_input(arm):
    other = Arm(random_model(13, 3))
    (found,) = singularities(other, [0.1, 0.2, 0.3])
    assert found.name == "smallest singular value"
    assert found.value == pytest.approx(singular_values(other, [0.1, 0.2, 0.3])[-1])
    assert lost_directions(other, [0.1, 0.2, 0.3]).shape == (3, 6)
    with pytest.raises(UnknownName, match="translation"):
        manipulability(arm, Q, "linear")
    with pytest.raises(ShapeError, match="one configuration"):
        lost_directions(arm, [Q, Q])
    with pytest.raises(ShapeError, match=r"\(\.\.\., 6\)"):
        joint_torques(arm, Q, [1.0])
    with pytest.raises(ShapeError, match="direction"):
        largest_force(arm, Q, [0.0, 0.0, 0.0])
    with pytest.raises(OutOfLimits, match="shoulder"):
        largest_force(arm.with_gravity((0.0, 0.0, -98.1)), [0.0, 0.0, -1.5, 0.0, 0.1, 0.0], [1.0, 0.0, 0.0])


ONE = {
    "singular_values": singular_values,
    "velocity_ellipsoid": velocity_ellipsoid,
    "velocity_ellipsoid of the rotation": lambda arm, q: velocity_ellipsoid(arm, q, "rotation"),
    "velocity_ellipsoid of all": lambda arm, q: velocity_ellipsoid(arm, q, "all"),
    "force_ellipsoid": force_ellipsoid,
    "lost_directions": lost_directions,
    "nullspace": nullspace,
    "singularities": singularities,
    "joint_rates": lambda arm, q: joint_rates(arm, q, [0.1, -0.2, 0.3, -0.4, 0.5, 0.6]),
}


@pytest.fixture(scope="module")
def arms():
    return [load_arm("puma560"), load_arm("ur5e"), load_arm("panda"), *(Arm(random_model(k, k)) for k in (2, 4, 9))]


def _configurations(arm):
    rng = np.random.default_rng(arm.n)
    yield np.zeros(arm.n)
    for k in range(12):
        q = rng.uniform(-2.5, 2.5, arm.n)
        if arm.n > 5 and k % 2:
            q[4] = 0.0
        yield q


def test_one_array_goes_the_compiled_way_to_what_a_list_gives(arms):
    """Joint rates run in control loops: one compiled call for one sample."""
    for arm in arms:
        for q in _configurations(arm):
            np.testing.assert_allclose(
                ONE["joint_rates"](arm, q), ONE["joint_rates"](arm, q.tolist()), rtol=1e-7, atol=1e-9
            )


@pytest.mark.parametrize("name", ONE)
def test_a_bad_configuration_is_named(arms, name):
    for arm in arms[:2]:
        bad = np.zeros(arm.n)
        bad[1] = np.nan
        with pytest.raises(ShapeError, match=r"q\[1\] is nan"):
            ONE[name](arm, bad)
        with pytest.raises(ShapeError, match="q"):
            ONE[name](arm, np.zeros(arm.n + 1))


def test_bases_are_those_of_the_jacobian(arms):
    for arm in arms:
        for q in _configurations(arm):
            J, s = arm.jacobian(q), np.linalg.svd(arm.jacobian(q), compute_uv=False)
            rank = np.count_nonzero(s > 1e-6)
            L, N = lost_directions(arm, q), nullspace(arm, q)
            assert L.shape == (6 - rank, 6)
            assert N.shape == (arm.n, arm.n - rank)
            np.testing.assert_allclose(L @ L.T, np.eye(6 - rank), atol=1e-14)
            np.testing.assert_allclose(N.T @ N, np.eye(arm.n - rank), atol=1e-14)
            np.testing.assert_allclose(L @ J, 0.0, atol=1e-6)
            np.testing.assert_allclose(J @ N, 0.0, atol=1e-6)
            np.testing.assert_allclose(singular_values(arm, q), s, atol=1e-14 * s[0])
            least = singularities(arm, q, tolerance=9.0)[0].direction
            assert np.linalg.norm(least @ J) == pytest.approx(s[-1], abs=1e-14)
            for part, rows in (("translation", J[:3]), ("rotation", J[3:])):
                fast, strong = velocity_ellipsoid(arm, q, part), force_ellipsoid(arm, q, part)
                np.testing.assert_allclose((fast.axes * fast.radii**2) @ fast.axes.T, rows @ rows.T, atol=1e-13)
                np.testing.assert_array_equal(strong.axes, fast.axes[:, ::-1])
                assert (np.isinf(strong.radii) == (fast.radii[::-1] <= 1e-6)).all()


@pytest.mark.parametrize("damping", ["auto", 0.0, 1e-3, 0.1])
def test_joint_rates_are_the_sum_over_singular_values(arms, damping):
    rng = np.random.default_rng(7)
    for arm in arms:
        for q in _configurations(arm):
            J, twist = arm.jacobian(q), rng.normal(size=6)
            U, s, Vt = np.linalg.svd(J, full_matrices=False)
            square = max((0.02 * s[0]) ** 2 - s[-1] ** 2, 0.0) if damping == "auto" else damping**2
            gain = np.divide(s, s**2 + square, out=np.zeros_like(s), where=s > 1e-12 * s[0])
            wanted = Vt.T @ (gain * (U.T @ twist))
            np.testing.assert_allclose(joint_rates(arm, q, twist, damping=damping), wanted, rtol=1e-9, atol=1e-12)
            rows = joint_rates(arm, [q, q], twist, damping=damping)
            np.testing.assert_allclose(rows, [wanted, wanted], rtol=1e-9, atol=1e-12)


def test_only_what_is_near_has_a_direction(arms):
    for arm in arms[:3]:
        for q in _configurations(arm):
            for tolerance in (0.0, 0.02, 0.3, 9.0):
                found = singularities(arm, q, tolerance=tolerance)
                assert all((case.direction is not None) == case.near == (abs(case.value) < tolerance) for case in found)


def test_singularities_are_new_each_time_and_share_one_direction(arm):
    first, again = (singularities(arm, Q, tolerance=9.0) for _ in range(2))
    assert type(first) is tuple
    assert all(case.direction is first[0].direction for case in first)
    assert first[0].direction is not again[0].direction
    assert [type(x) for x in first[0]] == [str, float, bool, np.ndarray]
    assert [abs(case.value) for case in first] == sorted(abs(case.value) for case in first)
    assert [type(x) for x in singularities(arm, Q)[0]] == [str, float, bool, type(None)]
