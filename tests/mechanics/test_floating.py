"""An arm whose base moves: laws on the equations as floats, on random trees of every kind of joint."""

from __future__ import annotations

import numpy as np
import pytest
from arms import random_body, random_pose, random_tree

from holonom.errors import ModelError, ModelWarning
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.dynamics import floating, with_rotors
from holonom.mechanics.equations.dynamics.composite_body import floating_mass_matrix, mass_matrix
from holonom.mechanics.equations.dynamics.inertia import from_body
from holonom.mechanics.equations.dynamics.newton_euler import inverse_dynamics, on_moving_base
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import read_urdf

SEEDS = range(6)


def tree(seed: int):
    rng = np.random.default_rng(seed)
    model = random_tree(seed, 6)
    return rng, model, bodies_of(model), from_body(random_body(rng)), len(model.independent)


def forces(model, bodies, base, q, qd, qdd, twist, acceleration):
    wrench, tau = on_moving_base(model, bodies, base, (q, qd, qdd), twist, acceleration)
    return np.array([*wrench, *tau], float)


@pytest.mark.parametrize("seed", SEEDS)
def test_forces_are_linear_in_accelerations_by_the_mass_matrix(seed):
    rng, model, bodies, base, n = tree(seed)
    q, qd, twist = rng.normal(size=n), rng.normal(size=n), rng.normal(size=6)
    B = np.array(floating_mass_matrix(model, bodies, base, q), float)
    np.testing.assert_allclose(B, B.T, atol=1e-12)
    assert np.linalg.eigvalsh(B).min() > 0.0
    bias = forces(model, bodies, base, q, qd, [0.0] * n, twist, [0.0] * 6)
    a = rng.normal(size=6 + n)
    whole = forces(model, bodies, base, q, qd, a[6:], twist, a[:6])
    np.testing.assert_allclose(whole - bias, B @ a, atol=1e-9 * np.abs(whole).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_a_base_that_rests_is_an_arm_that_is_fixed(seed):
    rng, model, bodies, base, n = tree(seed)
    q, qd, qdd = rng.normal(size=(3, n))
    R = np.array(model.base)[:3, :3]
    lift = [*(-R.T @ np.array(model.gravity)), 0.0, 0.0, 0.0]
    moving = forces(model, bodies, base, q, qd, qdd, [0.0] * 6, lift)
    np.testing.assert_allclose(moving[6:], inverse_dynamics(model, bodies, q, qd, qdd), atol=1e-10)
    B = np.array(floating_mass_matrix(model, bodies, base, q), float)
    np.testing.assert_allclose(B[6:, 6:], mass_matrix(model, bodies, q), atol=1e-11)


@pytest.mark.parametrize("seed", SEEDS)
def test_work_is_the_rate_of_kinetic_energy(seed):
    """Power of wrench and torques = d/dt of half the rates times B times the rates, along a motion on the manifold."""
    rng, model, bodies, base, n = tree(seed)
    q, qd, qdd = rng.normal(size=(3, n))
    twist, rate = rng.normal(size=(2, 6))

    def energy(t):
        speeds = np.array([*(twist + rate * t), *(qd + qdd * t)])
        B = np.array(floating_mass_matrix(model, bodies, base, q + qd * t + 0.5 * qdd * t * t), float)
        return 0.5 * speeds @ B @ speeds

    h = 1e-5
    power = forces(model, bodies, base, q, qd, qdd, twist, rate) @ np.array([*twist, *qd])
    assert power == pytest.approx((energy(h) - energy(-h)) / (2 * h), rel=1e-6, abs=1e-6)


FREE = """<robot name="free"><link name="world"/>
<link name="body"><inertial><origin xyz="0.1 0 0.05"/><mass value="3"/>
<inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="-0.02"/></inertial></link>
<link name="arm"><inertial><origin xyz="0.2 0.1 0"/><mass value="1.5"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0.005" iyz="0"/></inertial></link>
<link name="plate"><inertial><origin xyz="0 0.1 0.1"/><mass value="0.7"/>
<inertia ixx="0.01" iyy="0.01" izz="0.015" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="free" type="floating"><origin xyz="0 0 2"/><parent link="world"/><child link="body"/></joint>
<joint name="turn" type="continuous"><origin xyz="0.3 0 0" rpy="0.3 0.4 0"/><parent link="body"/><child link="arm"/>
<axis xyz="0 1 0"/></joint>
<joint name="table" type="planar"><origin xyz="0 0.2 0"/><parent link="arm"/><child link="plate"/>
<axis xyz="0 0 1"/></joint>
</robot>"""


def test_a_floating_and_a_planar_joint_are_read():
    model = read_urdf(FREE)
    assert model.floating
    assert model.base[2][3] == 2.0
    assert model.base_body is not None
    assert model.base_body.mass == 3.0
    assert [joint.name for joint in model.joints] == ["turn", "table.x", "table.y", "table.turn"]
    assert [joint.unit for joint in model.joints] == ["rad", "m", "m", "rad"]
    assert [body.mass for body in model.bodies] == [1.5, 0.0, 0.0, 0.7]
    again = FREE.replace("</robot>", '<joint name="f2" type="floating"><parent link="plate"/><child link="x"/></joint>'
                         '<link name="x"/></robot>')  # fmt: skip
    with pytest.raises(ModelError, match="only the base of a robot may float"):
        read_urdf(again, check="strict")
    with pytest.warns(ModelWarning, match="'f2' floats, and not all that moves hangs on it: it is fixed"):
        held = read_urdf(again)
    assert held.floating
    assert next(frame for frame in held.frames if frame.name == "x").joint == 3


def test_momentum_is_kept_in_free_flight():
    """Compiled, integrated by RK4 on the group: without gravity [p; L] stays, with it p falls and L follows."""
    arm = Arm(read_urdf(FREE)).with_gravity([0.0, 0.0, 0.0])
    rng = np.random.default_rng(1)
    base, twist = np.array(arm.model.base), 0.5 * rng.normal(size=6)
    q, qd, tau = rng.normal(size=4), rng.normal(size=4), 0.3 * rng.normal(size=4)
    before, dt = floating.momentum(arm, q, qd, base=base, twist=twist), 1e-3

    def rates(base, twist, q, qd):
        return np.concatenate(floating.forward_dynamics(arm, q, qd, tau, base=base, twist=twist))

    start = q
    for _ in range(400):
        k1 = rates(base, twist, q, qd)
        half, speed = twist + 0.5 * dt * k1[:6], qd + 0.5 * dt * k1[6:]
        k2 = rates(floating.moved(base, twist, 0.5 * dt), half, q + 0.5 * dt * qd, speed)
        base, q = floating.moved(base, half, dt), q + dt * speed
        twist, qd = twist + dt * k2[:6], qd + dt * k2[6:]
    assert np.abs(q - start).max() > 0.1
    np.testing.assert_allclose(floating.momentum(arm, q, qd, base=base, twist=twist), before, atol=2e-6)
    falling = arm.with_gravity([0.0, 0.0, -9.81])
    found = floating.forward_dynamics(falling, q, qd, tau, base=base, twist=twist)
    still = floating.forward_dynamics(arm, q, qd, tau, base=base, twist=twist)
    np.testing.assert_allclose(found.qdd, still.qdd, atol=1e-9)  # in free fall nobody feels it
    np.testing.assert_allclose(base[:3, :3] @ (found.acceleration - still.acceleration)[:3], [0, 0, -9.81], atol=1e-9)


def test_forward_undoes_inverse_and_the_jacobian_is_the_derivative():
    arm = load_arm("puma560")
    rng = np.random.default_rng(2)
    base, (q, qd, qdd), (twist, rate) = random_pose(rng), rng.normal(size=(3, 6)), rng.normal(size=(2, 6))
    needed = floating.inverse_dynamics(arm, q, qd, qdd, base=base, twist=twist, acceleration=rate)
    found = floating.forward_dynamics(arm, q, qd, needed.tau, base=base, twist=twist, wrench=needed.wrench)
    np.testing.assert_allclose(np.concatenate(found), [*rate, *qdd], atol=1e-8)
    J = floating.jacobian(arm, q, base=base)
    h = 1e-6
    there, here = (arm.with_base(floating.moved(base, twist, s)).fk(q + s * qd) for s in (h, -h))
    spin = (there[:3, :3] - here[:3, :3]) @ here[:3, :3].T / (2 * h)
    velocity = [*(there[:3, 3] - here[:3, 3]) / (2 * h), spin[2, 1], spin[0, 2], spin[1, 0]]
    np.testing.assert_allclose(J @ [*twist, *qd], velocity, atol=1e-5)
    with pytest.raises(ModelError, match="rotors='full'"):
        floating.mass_matrix(with_rotors(arm, "full"), q)


@pytest.mark.oracle
@pytest.mark.parametrize("seed", range(3))
def test_free_flyer_of_pinocchio(seed, pinocchio):
    """B, inverse and forward dynamics of a URDF with Pinocchio's free-flyer at its root."""
    text = FREE.replace('type="floating"', 'type="fixed"').replace('type="planar"', 'type="continuous"')
    theirs = pinocchio.buildModelFromXML(text, pinocchio.JointModelFreeFlyer())
    data = theirs.createData()
    mine = Arm(read_urdf(text, root="world"))
    rng = np.random.default_rng(seed)
    T = random_pose(rng)
    q, qd, qdd = rng.normal(size=(3, 2))
    twist, rate = rng.normal(size=(2, 6))
    # continuous joints are (cos, sin) there, and the base's quaternion comes with its scalar last
    place = np.concatenate([pinocchio.SE3ToXYZQUAT(pinocchio.SE3(T)), *((np.cos(x), np.sin(x)) for x in q)])
    B = pinocchio.crba(theirs, data, place)
    B = np.triu(B) + np.triu(B, 1).T
    np.testing.assert_allclose(floating.mass_matrix(mine, q), B, atol=1e-9)
    expected = pinocchio.rnea(theirs, data, place, np.concatenate([twist, qd]), np.concatenate([rate, qdd]))
    found = floating.inverse_dynamics(mine, q, qd, qdd, base=T, twist=twist, acceleration=rate)
    np.testing.assert_allclose(np.concatenate(found), expected, atol=1e-9)
    forces = rng.normal(size=8)
    expected = pinocchio.aba(theirs, data, place, np.concatenate([twist, qd]), forces)
    found = floating.forward_dynamics(mine, q, qd, forces[6:], base=T, twist=twist, wrench=forces[:6])
    np.testing.assert_allclose(np.concatenate(found), expected, atol=1e-8)


@pytest.mark.oracle
def test_planar_joint_of_pinocchio(pinocchio):
    """Its rates are along the plate's own axes, ours along the table's; B is the same but for that turn."""
    text = FREE.replace('type="floating"', 'type="fixed"')
    theirs = pinocchio.buildModelFromXML(text, pinocchio.JointModelFreeFlyer())
    data, mine = theirs.createData(), Arm(read_urdf(text, root="world"))
    rng = np.random.default_rng(5)
    T, q = random_pose(rng), rng.normal(size=4)
    c, s = np.cos(q[3]), np.sin(q[3])
    turn = [np.cos(q[0]), np.sin(q[0])]
    place = np.concatenate([pinocchio.SE3ToXYZQUAT(pinocchio.SE3(T)), turn, [q[1], q[2], c, s]])
    B = pinocchio.crba(theirs, data, place)
    B = np.triu(B) + np.triu(B, 1).T
    own = np.eye(10)
    own[7:9, 7:9] = [[c, s], [-s, c]]
    np.testing.assert_allclose(floating.mass_matrix(mine, q), own.T @ B @ own, atol=1e-9)
    pinocchio.forwardKinematics(theirs, data, place)
    pinocchio.updateFramePlacements(theirs, data)
    plate = data.oMf[theirs.getFrameId("plate")].homogeneous
    np.testing.assert_allclose(mine.with_base(T).fk(q, "plate"), plate, atol=1e-12)
