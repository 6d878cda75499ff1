"""Coriolis matrix, energies, momenta and both rotor models against Lagrange's equations from Jacobians alone."""

import dataclasses

import numpy as np
import pytest
from arms import presets, random_model, random_tree
from scipy.spatial.transform import Rotation

from holonom.errors import MissingInertia, ModelError, UnknownName
from holonom.mechanics import Arm, arm_from_dh, dynamics, load_arm
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import composite_body, coriolis, energy, newton_euler
from holonom.mechanics.kernels.table import bodies_of
from holonom.model import Body, DHRow, Motor


def geared(model, **options):
    """The model with a heavy rotor on every joint, its axis askew, on the link before."""
    rng = np.random.default_rng(17)
    joints = []
    for joint in model.joints:
        axis = rng.normal(size=3)
        motor = Motor(
            gear_ratio=float(rng.uniform(-20, 20)),
            rotor_inertia=float(rng.uniform(0.01, 0.05)),
            axis=tuple((axis / np.linalg.norm(axis)).tolist()),
            position=tuple(rng.uniform(-0.2, 0.2, 3).tolist()),
            mass=2.0,
            transverse_inertia=0.03,
        )
        joints.append(dataclasses.replace(joint, motor=motor))
    return dataclasses.replace(model, joints=tuple(joints), **options)


RANDOM = [random_model(seed, n) for seed, n in ((1, 2), (2, 4), (4, 7))] + [
    random_tree(seed, n) for seed, n in ((5, 4), (6, 7))
]
PLAIN = [arm.model for arm in presets() if arm.model.bodies is not None] + RANDOM
FULL = [geared(m, rotors="full", links_include_rotors=inside) for m in RANDOM for inside in (True, False)]
MODELS = PLAIN + FULL
IDS = [f"{m.name}-{m.rotors}-{'in' if m.links_include_rotors else 'extra'}" for m in MODELS]
REFLECTED = pytest.mark.parametrize("model", PLAIN, ids=IDS[: len(PLAIN)])
EVERY = pytest.mark.parametrize("model", MODELS, ids=IDS)


def motion(model, seed=0):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (3, len(model.independent)))


def floats(rows):
    return np.array(rows, dtype=float)


def velocity_maps(model, q):
    """World frames and the maps of all joint rates to each frame's angular velocity; the joints' axes and points."""
    frames = [(floats(R), floats(p)) for R, p in kinematics.frames(model, q.tolist())]
    axes = []
    for i, joint in enumerate(model.joints):
        R, p = frames[model.parent(i) + 1]
        before = np.array(joint.before)
        axes.append((R @ before[:3, 2], p + R @ before[:3, 3], joint.kind))
    return frames, axes


def maps_at(model, axes, i, point):
    """Jp and Jo of a point fixed to frame i (specification 1.4)."""
    Jp, Jo = np.zeros((3, len(axes))), np.zeros((3, len(axes)))
    for j in kinematics.carrying(model, i):
        z, p, kind = axes[j]
        Jp[:, j], Jo[:, j] = (np.cross(z, point - p), z) if kind == "revolute" else (z, 0.0)
    return Jp, Jo


def tensor(body):
    xx, yy, zz, xy, yz, xz = body.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def lagrangian(model, q):
    """B(q) as the specification sums it over links and motors (2.1), and U(q)."""
    frames, axes = velocity_maps(model, q)
    n, g = len(model.joints), np.array(model.gravity)
    B, U = np.zeros((n, n)), 0.0

    def add_mass(i, m, com, inertia, spin=None):
        nonlocal B, U
        R, p = frames[i + 1]
        point = p + R @ com
        Jp, Jo = maps_at(model, axes, i, point)
        if spin is not None:
            Jo[:, spin[0]] += R @ spin[1]
        B = B + m * Jp.T @ Jp + Jo.T @ R @ inertia @ R.T @ Jo
        U = U - m * g @ point

    for i, body in enumerate(model.bodies):
        add_mass(i, body.mass, np.array(body.com), tensor(body))
    for i, joint in enumerate(model.joints):
        motor, carrier = joint.motor, model.parent(i)
        if motor is None:
            continue
        if model.rotors == "reflected" or carrier < 0:
            B[i, i] += motor.gear_ratio**2 * motor.rotor_inertia
            continue
        z = np.array(motor.axis)
        along = motor.rotor_inertia * np.outer(z, z)
        spin = (i, motor.gear_ratio * z)
        if model.links_include_rotors:  # the link holds the locked rotor: add the spinning one, take the locked away
            add_mass(carrier, 0.0, np.zeros(3), along, spin)
            add_mass(carrier, 0.0, np.zeros(3), -along)
        else:
            across = motor.transverse_inertia * (np.eye(3) - np.outer(z, z))
            add_mass(carrier, motor.mass, np.array(motor.position), along + across, spin)
    return independent(model, B), U


def independent(model, B):
    G = np.zeros((len(model.joints), len(model.independent)))
    for k, unit in enumerate(np.eye(len(model.independent))):
        G[:, k] = kinematics.spread(model, unit.tolist(), rates=True)
    return G.T @ B @ G


def slopes(model, q, h=1e-4):
    """DB/dq_k (k first) and dU/dq by differences of fourth order."""
    steps = [[lagrangian(model, q + s * h * e) for s in (-2, -1, 1, 2)] for e in np.eye(len(q))]
    parts = [[(a - 8 * b + 8 * c - d) / (12 * h) for a, b, c, d in zip(*step, strict=True)] for step in steps]
    return np.array([p[0] for p in parts]), np.array([p[1] for p in parts])


@EVERY
def test_newton_euler_and_mass_matrix_are_lagrange(model):
    q, qd, qdd = motion(model, 1)
    bodies = bodies_of(model)
    B, U = lagrangian(model, q)
    dB, dU = slopes(model, q)
    scale = np.abs(B).max()
    np.testing.assert_allclose(floats(composite_body.mass_matrix(model, bodies, q.tolist())), B, atol=1e-12 * scale)
    assert float(energy.kinetic_energy(model, bodies, q.tolist(), qd.tolist())) == pytest.approx(0.5 * qd @ B @ qd)
    assert float(energy.potential_energy(model, bodies, q.tolist())) == pytest.approx(U, abs=1e-12)
    tau = B @ qdd + np.einsum("kij,k,j->i", dB, qd, qd) - 0.5 * np.einsum("ijk,j,k->i", dB, qd, qd) + dU
    found = floats(newton_euler.inverse_dynamics(model, bodies, q.tolist(), qd.tolist(), qdd.tolist()))
    np.testing.assert_allclose(found, tau, atol=1e-9 * np.abs(tau).max())


@REFLECTED
def test_coriolis_matrix_is_that_of_the_christoffel_symbols(model):
    q, qd, _ = motion(model, 2)
    bodies = bodies_of(model)
    dB, _ = slopes(model, q)
    c = 0.5 * (np.einsum("kij->ijk", dB) + np.einsum("jik->ijk", dB) - dB)
    found = floats(coriolis.christoffel(model, bodies, q.tolist()))
    scale = np.abs(lagrangian(model, q)[0]).max()
    np.testing.assert_allclose(found, c, atol=1e-9 * scale)
    np.testing.assert_array_equal(found, found.swapaxes(1, 2))
    C = floats(coriolis.coriolis_matrix(model, bodies, q.tolist(), qd.tolist()))
    np.testing.assert_allclose(C, found @ qd, atol=1e-12 * max(1.0, np.abs(C).max()))
    N = np.einsum("kij,k->ij", dB, qd) - 2.0 * C
    np.testing.assert_allclose(N, -N.T, atol=1e-9 * scale)
    bias = floats(
        newton_euler.inverse_dynamics(model, bodies, q.tolist(), qd.tolist(), (0 * q).tolist(), gravity=[0.0] * 3)
    )
    np.testing.assert_allclose(C @ qd, bias, atol=1e-12 * max(1.0, np.abs(bias).max()))


@REFLECTED
def test_momentum_of_all_bodies(model):
    """P = M c', and L about the centre changes by nothing but the wrench at the base."""
    q, qd, _ = (v.tolist() for v in motion(model, 3))
    bodies = bodies_of(model)
    h = energy.centroidal_momentum(model, bodies, q, qd)
    frames, axes = velocity_maps(model, np.array(q))
    rates = np.array(kinematics.spread(model, qd, rates=True), dtype=float)
    total = sum(b.mass for b in model.bodies)
    centre = floats(energy.centre_of_mass(model, bodies, q))
    P, L = np.zeros(3), np.zeros(3)
    for i, body in enumerate(model.bodies):
        R, p = frames[i + 1]
        point = p + R @ body.com
        Jp, Jo = maps_at(model, axes, i, point)
        P += body.mass * Jp @ rates
        L += body.mass * np.cross(point - centre, Jp @ rates) + R @ tensor(body) @ R.T @ Jo @ rates
    np.testing.assert_allclose(floats(h), [*P, *L], atol=1e-12 * max(1.0, np.abs(L).max(), np.abs(P).max()))
    step = 1e-6
    ahead, behind = (
        floats(energy.centre_of_mass(model, bodies, (np.array(q) + s * np.array(qd)).tolist())) for s in (step, -step)
    )
    np.testing.assert_allclose(floats(h[:3]), total * (ahead - behind) / (2 * step), atol=1e-7 * total)


COMPILED = [load_arm("puma560"), Arm(random_tree(5, 4)), Arm(FULL[-3])]


@pytest.mark.parametrize("arm", COMPILED, ids=["puma560", "tree", "tree-full"])
def test_verbs(arm):
    q, qd, qdd = motion(arm.model, 4)
    C, c, table = arm.coriolis_matrix(q, qd), dynamics.christoffel(arm, q), dynamics.coupling_table(arm, q)
    bias = dynamics.bias(arm, q, qd, friction=False)
    scale = np.abs(arm.mass_matrix(q)).max()
    np.testing.assert_allclose(c @ qd, C, atol=1e-12 * scale)
    np.testing.assert_allclose(C @ qd + arm.gravity(q), bias, atol=1e-11 * scale)
    dB, _ = slopes(arm.model, q)
    N = np.einsum("kij,k->ij", dB, qd) - 2.0 * C
    np.testing.assert_allclose(N, -N.T, atol=1e-9 * scale)
    tau = (
        table.gravity
        + table.inertia @ qdd
        + table.centrifugal @ qd**2
        + np.einsum("ijk,j,k->i", table.coriolis, qd, qd)
    )
    np.testing.assert_allclose(tau, arm.inverse_dynamics(q, qd, qdd, friction=False), atol=1e-11 * scale)
    assert not np.einsum("ijj->ij", table.coriolis).any()
    B, U = lagrangian(arm.model, q)
    found = dynamics.energy(arm, np.tile(q, (3, 1)), qd)
    np.testing.assert_allclose(found.kinetic, [0.5 * qd @ B @ qd] * 3)
    np.testing.assert_allclose(found.potential, [U] * 3)
    np.testing.assert_allclose(dynamics.momentum(arm, q, qd), B @ qd, atol=1e-12 * scale)
    bodies, state = bodies_of(arm.model), (q.tolist(), qd.tolist())
    expected = floats(energy.centroidal_momentum(arm.model, bodies, *state))
    np.testing.assert_allclose(dynamics.centroidal_momentum(arm, q, qd), expected, atol=1e-11)
    np.testing.assert_allclose(
        dynamics.centre_of_mass(arm, q), floats(energy.centre_of_mass(arm.model, bodies, state[0])), atol=1e-13
    )


def test_derivatives_with_full_rotors():
    """They come from the graph; differences of the verbs are the check."""
    arm = Arm(FULL[-3])
    q, qd, x = motion(arm.model, 5)
    h, steps = 1e-5, 1e-5 * np.eye(arm.n)
    cases = (
        (dynamics.inverse_dynamics_derivatives, arm.inverse_dynamics),
        (dynamics.forward_dynamics_derivatives, arm.forward_dynamics),
    )
    for derivatives, verb in cases:
        found = derivatives(arm, q, qd, x)
        expected = (
            (verb(q + steps, qd, x) - verb(q - steps, qd, x)).T / (2 * h),
            (verb(q, qd + steps, x) - verb(q, qd - steps, x)).T / (2 * h),
            (verb(q, qd, x + steps) - verb(q, qd, x - steps)).T / (2 * h),
        )
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b, atol=2e-8 * max(1.0, np.abs(b).max()))


def test_full_rotors_reduce_to_reflected_ones_for_a_light_rotor_and_a_large_ratio():
    """The coupling goes with k I, the reflected inertia with k^2 I."""
    q = motion(RANDOM[1], 6)[0]
    apart = []
    for ratio in (10.0, 1000.0):
        joints = [
            dataclasses.replace(j, motor=Motor(ratio, 1.0 / ratio**2, axis=(0.0, 0.0, 1.0))) for j in RANDOM[1].joints
        ]
        arm = Arm(dataclasses.replace(RANDOM[1], joints=tuple(joints)))
        full = dynamics.with_rotors(arm, "full").mass_matrix(q)
        apart.append(np.abs(full - arm.mass_matrix(q)).max())
    assert apart[0] > 0.05
    assert apart[1] == pytest.approx(apart[0] / 100.0, rel=1e-6)


def test_rotors_without_an_axis_are_named():
    arm = load_arm("puma560")
    with pytest.raises(ModelError, match=r"'shoulder'.*axis"):
        dynamics.with_rotors(arm, "full").gravity(np.zeros(6))
    with pytest.raises(ModelError, match="axis"):
        Arm(dataclasses.replace(arm.model, links_include_rotors=False)).gravity(np.zeros(6))
    with pytest.raises(UnknownName, match="reflected"):
        dynamics.with_rotors(arm, "none")
    with pytest.raises(ModelError, match="unit vector"):
        Motor(1.0, 1.0, axis=(1.0, 1.0, 0.0))
    with pytest.raises(ModelError, match="negative"):
        Motor(1.0, 1.0, mass=-1.0)


def test_a_payload_is_stated_in_the_tool():
    """It weighs, and gives the momentum, of the same body fixed to the last link."""
    load = Body(2.0, (0.01, -0.02, 0.1), (0.01, 0.02, 0.015, 0.001, 0.002, -0.001))
    arm, tool = load_arm("puma560"), np.eye(4)
    tool[:3, :3], tool[:3, 3] = Rotation.from_euler("xyz", [0.3, -0.4, 1.2]).as_matrix(), [0.05, 0.0, 0.2]
    q, qd, _ = motion(arm.model, 7)
    with_tool = arm.with_tool(tool)
    heavy = dynamics.with_payload(with_tool, load)
    T = with_tool.fk(q)
    force = load.mass * np.array([0.0, 0.0, 9.81])
    lever = T[:3, :3] @ load.com
    wrench = np.concatenate([force, np.cross(lever, force)])
    np.testing.assert_allclose(heavy.gravity(q), arm.gravity(q) + with_tool.jacobian(q).T @ wrench, atol=1e-10)
    J = with_tool.jacobian(q)
    w, v = J[3:] @ qd, J[:3] @ qd + np.cross(J[3:] @ qd, lever)
    inertia = T[:3, :3] @ tensor(load) @ T[:3, :3].T
    added = 0.5 * load.mass * v @ v + 0.5 * w @ inertia @ w
    kinetic = [dynamics.energy(a, q, qd).kinetic for a in (arm, heavy)]
    assert kinetic[1] - kinetic[0] == pytest.approx(added)
    bare = arm_from_dh([DHRow(a=1.0)], convention="standard", name="bare")
    with pytest.raises(MissingInertia, match="bare"):
        dynamics.with_payload(bare, load)


@pytest.mark.oracle
def test_against_pinocchio(pinocchio):
    pin = pinocchio
    from peers import pinocchio_model

    for model in (load_arm("puma560").model, RANDOM[1], RANDOM[2]):
        q, qd, _ = motion(model, 8)
        bodies, state = bodies_of(model), (q.tolist(), qd.tolist())
        peer = pinocchio_model(pin, Arm(model))
        data = peer.createData()
        pin.computeCoriolisMatrix(peer, data, q, qd)
        C = floats(coriolis.coriolis_matrix(model, bodies, *state))
        np.testing.assert_allclose(C @ qd, data.C @ qd, atol=1e-10 * np.abs(C).max())
        kinetic = pin.computeKineticEnergy(peer, data, q, qd)
        assert float(energy.kinetic_energy(model, bodies, *state)) == pytest.approx(kinetic, rel=1e-10)
        potential = pin.computePotentialEnergy(peer, data, q)
        assert float(energy.potential_energy(model, bodies, state[0])) == pytest.approx(potential, rel=1e-10)
        h = pin.computeCentroidalMomentum(peer, data, q, qd)
        ours = floats(energy.centroidal_momentum(model, bodies, *state))
        np.testing.assert_allclose(ours, [*h.linear, *h.angular], atol=1e-10 * np.abs(ours).max())
        centre = pin.centerOfMass(peer, data, q)
        np.testing.assert_allclose(floats(energy.centre_of_mass(model, bodies, state[0])), centre, atol=1e-12)
