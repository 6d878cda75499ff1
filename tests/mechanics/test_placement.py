"""Another base, tool, gravity or load: as if the arm were made so, and nothing is compiled for it."""

from __future__ import annotations

import numpy as np
import pytest
from arms import random_body, random_pose

from holonom.errors import NotAPose, UnknownName
from holonom.mechanics import load_arm
from holonom.mechanics.dynamics import with_payload
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics.composite_body import mass_matrix
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.equations.dynamics.newton_euler import inverse_dynamics
from holonom.mechanics.kernels.placement import bodies_of
from holonom.mechanics.numerical_inverse import solve_inverse
from holonom.mechanics.simulate import ComputedTorque, simulate


def moved(arm, rng):
    body = random_body(rng)
    return with_payload(arm.with_base(random_pose(rng)).with_tool(random_pose(rng)), body).with_gravity(
        rng.normal(size=3)
    )


def quantities(arm, q, qd, qdd):
    J = arm.jacobian(q, "tool")
    wrench = np.arange(6.0)
    return [
        arm.fk(q),
        arm.fk(q, "link2"),
        arm.frames(q),
        J,
        arm.inverse_dynamics(q, qd, qdd),
        arm.inverse_dynamics(q, qd, qdd, wrench=wrench, wrench_frame="world"),
        arm.forward_dynamics(q, qd, qdd),
        arm.mass_matrix(q),
        arm.gravity(q),
    ]


def test_it_is_the_arm_made_so():
    """Against the equations on the numbers of the model that it states."""
    rng = np.random.default_rng(0)
    here = moved(load_arm("puma560"), rng)
    model, bodies = here.model, bodies_of(here.model)
    q, qd, qdd = rng.normal(size=(3, 5, 6))
    x, y, z = q[0], qd[0], qdd[0]
    poses = [kinematics.flat_pose(T) for T in kinematics.frames(model, x)]
    R = np.array(poses[-1], float).reshape(4, 4)[:3, :3]
    tool = [*(R.T @ np.arange(3.0)), *(R.T @ np.arange(3.0, 6.0))]
    wanted = [
        poses[-1],
        poses[2],
        poses,
        kinematics.jacobian(model, x, "tool"),
        inverse_dynamics(model, bodies, x, y, z, friction=True),
        inverse_dynamics(model, bodies, x, y, z, friction=True, wrench_tool=tool),
        forward_dynamics(model, bodies, x, y, z, friction=True),
        mass_matrix(model, bodies, x),
        inverse_dynamics(model, bodies, x, 0 * x, 0 * x),
    ]
    for a, b in zip(quantities(here, x, y, z), wanted, strict=True):
        np.testing.assert_allclose(a, np.array(b, float).reshape(a.shape), atol=1e-10, rtol=1e-10)
    np.testing.assert_allclose(here.fk(q)[0], here.fk(x), atol=1e-12)  # rows
    np.testing.assert_allclose(here.inverse_dynamics(q, qd, qdd)[0], here.inverse_dynamics(x, y, z), atol=1e-9)


@pytest.mark.parametrize("name", ["puma560", "panda"])
def test_moving_compiles_nothing(name, tmp_path, monkeypatch):
    """Once it stood elsewhere, an arm needs no other code for any base, tool, gravity and load."""
    log = tmp_path / "kernels"
    monkeypatch.setenv("HOLONOM_CACHE_LOG", str(log))
    rng = np.random.default_rng(1)
    arm = load_arm(name)
    home = np.clip(np.full(arm.n, 0.3), arm.limits.lower + 0.3, arm.limits.upper - 0.3)
    for again in (False, True, True):
        q = home + 0.1 * rng.normal(size=arm.n)
        there = moved(arm, rng)
        if name == "puma560":
            quantities(there, q, q, q)
        found = there.ik_nearest(there.fk(q), home)
        np.testing.assert_allclose(there.fk(found.q), there.fk(q), atol=2e-6)
        assert solve_inverse(there, there.fk(q), home).status == 0
        if name == "puma560":
            assert there.ik(there.fk(q)).q.shape == (8, 6)
            simulate(there, ComputedTorque(100.0, 20.0, q), q, np.zeros(arm.n), 0.02)
        made = log.read_text("utf-8") if log.exists() else ""
        assert not (again and made), made
        assert again or made
        log.write_text("", "utf-8")


def test_closed_form_elsewhere():
    rng = np.random.default_rng(2)
    for name in ("ur5e", "scara", "planar2r"):
        arm = load_arm(name)
        there = arm.with_base(random_pose(rng))
        q = np.clip(rng.normal(size=(20, arm.n)), arm.limits.lower + 0.05, arm.limits.upper - 0.05)
        near = there.ik_nearest(there.fk(q), q)
        np.testing.assert_allclose(there.fk(near.q)[..., :3, 3], there.fk(q)[..., :3, 3], atol=1e-8)
        assert (near.status != 1).all()
    point = load_arm("planar2r").with_tool([[1, 0, 0, 0.1], [0, 1, 0, 0.2], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    q = np.array([0.3, 0.8])
    found = point.ik(point.fk(q)[:3, 3])
    assert np.abs(found.q - q).max(-1).min() < 1e-9
    with pytest.raises(NotAPose, match="no rotation"):
        load_arm("ur5e").with_base(random_pose(rng)).ik(2.0 * np.eye(4))


def test_a_base_for_each_row():
    rng = np.random.default_rng(3)
    arm = load_arm("puma560")
    bases = np.array([random_pose(rng) for _ in range(4)])
    q = rng.normal(size=(4, 6))
    kernel = arm.kernel("fk", given=("base",))
    each = [arm.with_base(T).fk(row) for T, row in zip(bases, q, strict=True)]
    np.testing.assert_allclose(kernel(q, bases), each, atol=1e-12)
    with pytest.raises(UnknownName, match="input of an arm's kernels"):
        arm.kernel("fk", given=("wrist",))


def test_limits_stay_with_the_place():
    arm = load_arm("ur5e").with_base(random_pose(np.random.default_rng(4)))
    slow = arm.with_limits(speed=0.5)
    np.testing.assert_allclose(slow.limits.speed, 0.5 * arm.limits.speed)
    np.testing.assert_allclose(slow.fk(np.zeros(6)), arm.fk(np.zeros(6)))
    assert slow.placement is not None
