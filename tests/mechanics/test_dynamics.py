"""Laws of the equations of motion, an independent Lagrange derivation, and published numbers of the Puma 560."""

import json

import numpy as np
import pytest
from arms import presets, random_model, random_tree
from peers import pinocchio_model

from holonom.errors import InputError, MissingInertia, ShapeError, UnknownName
from holonom.mechanics import Arm, arm_from_dh, load_arm
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import composite_body, newton_euler
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.equations.dynamics.inertia import fixed_to_body
from holonom.mechanics.kernels.table import bodies_of
from holonom.model import Body, DHRow

MODELS = [
    *(arm.model for arm in presets()),
    *(random_model(seed, n) for seed, n in ((1, 2), (2, 4), (3, 6), (4, 7), (8, 13))),
    *(random_tree(seed, n) for seed, n in ((5, 4), (6, 7))),
]
NAMES = [m.name for m in MODELS]


def motion(model, seed=0):
    rng = np.random.default_rng(seed)
    n = len(model.independent)
    return [rng.uniform(-1.5, 1.5, n).tolist() for _ in range(3)]


def rotation(model, frames, i):
    return np.array(frames[i + 1][0], dtype=float), np.array(frames[i + 1][1], dtype=float)


def energies(model, q, qd):
    """Kinetic and potential energy from the frames alone, velocities by central differences: no recursion shared."""
    h = 1e-6
    q, qd = np.array(q), np.array(qd)
    now = kinematics.frames(model, q.tolist())
    ahead = kinematics.frames(model, (q + h * qd).tolist())
    behind = kinematics.frames(model, (q - h * qd).tolist())
    kinetic = potential = 0.0
    for i, body in enumerate(model.bodies):
        (R, p), (Ra, pa), (Rb, pb) = (rotation(model, f, i) for f in (now, ahead, behind))
        c = np.array(body.com)
        v = ((pa + Ra @ c) - (pb + Rb @ c)) / (2 * h)
        W = R.T @ (Ra - Rb) / (2 * h)
        w = np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1]]) / 2
        xx, yy, zz, xy, yz, xz = body.inertia
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        kinetic += 0.5 * body.mass * v @ v + 0.5 * w @ inertia @ w
        potential -= body.mass * np.array(model.gravity) @ (p + R @ c)
    rotor = np.array(newton_euler.reflected_inertia(model))
    rates = np.array(kinematics.spread(model, qd.tolist(), rates=True), dtype=float)
    return kinetic + 0.5 * rotor @ np.square(rates), potential


@pytest.mark.parametrize("model", MODELS, ids=NAMES)
def test_mass_matrix_is_symmetric_positive_and_gives_the_kinetic_energy(model):
    q, qd, _ = motion(model)
    B = np.array(composite_body.mass_matrix(model, bodies_of(model), q), dtype=float)
    np.testing.assert_allclose(B, B.T, atol=1e-14)
    assert np.linalg.eigvalsh(B).min() > 0.0
    kinetic, _ = energies(model, q, qd)
    assert 0.5 * np.array(qd) @ B @ qd == pytest.approx(kinetic, rel=1e-7)


@pytest.mark.parametrize("model", MODELS, ids=NAMES)
def test_newton_euler_equals_lagrange(model):
    """tau = d/dt dT/dqd - dT/dq + dU/dq with B from the energies' side: gravity, inertia and Coriolis terms apart."""
    bodies = bodies_of(model)
    q, qd, qdd = motion(model, 1)
    n = len(q)
    h = 1e-5
    B = lambda x: np.array(composite_body.mass_matrix(model, bodies, x.tolist()), dtype=float)  # noqa: E731
    x = np.array(q)
    steps = h * np.eye(n)
    dB = np.array([(B(x + e) - B(x - e)) / (2 * h) for e in steps])
    coriolis = np.einsum("kij,k,j->i", dB, qd, qd) - 0.5 * np.einsum("ijk,j,k->i", dB, qd, qd)
    slope = np.array(
        [energies(model, x + e, np.zeros(n))[1] - energies(model, x - e, np.zeros(n))[1] for e in steps]
    ) / (2 * h)
    lagrange = B(x) @ qdd + coriolis + slope
    newton = np.array(newton_euler.inverse_dynamics(model, bodies, q, qd, qdd), dtype=float)
    np.testing.assert_allclose(newton, lagrange, rtol=1e-6, atol=1e-6 * np.abs(lagrange).max())


@pytest.mark.parametrize("model", MODELS, ids=NAMES)
def test_forward_after_inverse_is_identity_and_power_balances(model):
    bodies = bodies_of(model)
    q, qd, qdd = motion(model, 2)
    tau = newton_euler.inverse_dynamics(model, bodies, q, qd, qdd, friction=True)
    again = np.array(forward_dynamics(model, bodies, q, qd, tau, friction=True), dtype=float)
    np.testing.assert_allclose(again, qdd, rtol=1e-9, atol=1e-9)
    free = newton_euler.inverse_dynamics(model, bodies, q, qd, qdd)
    h = 1e-5
    q, qd, qdd = map(np.array, (q, qd, qdd))
    late = energies(model, q + h * qd + 0.5 * h * h * qdd, qd + h * qdd)
    early = energies(model, q - h * qd + 0.5 * h * h * qdd, qd - h * qdd)
    power = (sum(late) - sum(early)) / (2 * h)
    assert np.dot(free, qd) == pytest.approx(power, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("model", MODELS, ids=NAMES)
def test_a_wrench_adds_jacobian_transpose(model):
    bodies, n = bodies_of(model), len(model.independent)
    q, qd, qdd = motion(model, 3)
    wrench = np.array([1.0, -2.0, 3.0, 0.4, -0.5, 0.6])
    with_it = newton_euler.inverse_dynamics(model, bodies, q, qd, qdd, wrench_tool=wrench.tolist())
    added = np.subtract(with_it, newton_euler.inverse_dynamics(model, bodies, q, qd, qdd)).astype(float)
    J = np.array(kinematics.jacobian(model, q, "tool"), dtype=float).reshape(6, n)
    np.testing.assert_allclose(added, J.T @ wrench, atol=1e-10)


def test_a_wrench_in_the_world_is_turned_into_the_tool():
    arm = load_arm("puma560")
    q, qd, qdd = motion(arm.model, 3)
    wrench = np.array([1.0, -2.0, 3.0, 0.4, -0.5, 0.6])
    added = arm.inverse_dynamics(q, qd, qdd, wrench=wrench, wrench_frame="world") - arm.inverse_dynamics(q, qd, qdd)
    np.testing.assert_allclose(added, arm.jacobian(q).T @ wrench, atol=1e-10)


COMPILED = [arm.model for arm in presets()] + [random_model(1, 2), random_tree(5, 4)]


@pytest.mark.parametrize("model", COMPILED, ids=[m.name for m in COMPILED])
def test_compiled_equals_floats(model):
    arm, bodies = Arm(model), bodies_of(model)
    q, qd, qdd = motion(model, 4)
    floats = np.array(newton_euler.inverse_dynamics(model, bodies, q, qd, qdd, friction=True), dtype=float)
    tolerance = 1e-12 * np.abs(floats).max()
    np.testing.assert_allclose(arm.inverse_dynamics(q, qd, qdd), floats, atol=tolerance)
    rows = [np.tile(v, (70, 1)) for v in (q, qd, qdd)]
    np.testing.assert_allclose(arm.inverse_dynamics(*rows), np.tile(floats, (70, 1)), atol=tolerance)
    np.testing.assert_allclose(arm.forward_dynamics(q, qd, floats), qdd, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(
        arm.mass_matrix(q), np.array(composite_body.mass_matrix(model, bodies, q), dtype=float), atol=1e-12
    )
    rest = np.zeros(arm.n)
    np.testing.assert_allclose(arm.gravity(q), arm.inverse_dynamics(q, rest, rest), atol=tolerance)


def test_moving_base_and_gravity_together_changes_nothing():
    arm = load_arm("puma560")
    q, qd, qdd = motion(arm.model, 5)
    T = np.array([[0.0, -1.0, 0.0, 1.0], [0.0, 0.0, -1.0, 2.0], [1.0, 0.0, 0.0, 3.0], [0.0, 0.0, 0.0, 1.0]])
    moved = arm.with_base(T).with_gravity(T[:3, :3] @ arm.model.gravity)
    np.testing.assert_allclose(moved.inverse_dynamics(q, qd, qdd), arm.inverse_dynamics(q, qd, qdd), atol=1e-11)


def test_a_fixed_load_weighs_what_its_wrench_weighs():
    arm = load_arm("puma560")
    load = Body(2.0, (0.01, -0.02, 0.1), (0.01, 0.02, 0.015, 0.001, 0.002, -0.001))
    q, _, _ = motion(arm.model, 6)
    T = arm.fk(q, frame="link6")
    centre = T[:3, :3] @ load.com + T[:3, 3]
    J = arm.jacobian(q)
    weight = np.array([0.0, 0.0, -9.81 * load.mass])
    moment = np.cross(centre - arm.fk(q)[:3, 3], weight)
    expected = arm.gravity(q) - J.T @ np.concatenate([weight, moment])
    np.testing.assert_allclose(arm.with_load(load).gravity(q), expected, atol=1e-10)
    both = fixed_to_body(load, load)
    assert both.mass == 4.0
    np.testing.assert_allclose(both.com, load.com)
    np.testing.assert_allclose(both.inertia, 2 * np.array(load.inertia), atol=1e-12)


@pytest.fixture(scope="module")
def published(data_folder):
    return json.loads((data_folder / "robots" / "puma560_cases.json").read_text())


PUBLISHED = (
    "rne_qdd1",
    "rne_qd1_qdd1",
    "rne_qd1",
    "rne_qd1_qdd1_nograv",
    "rne_fext",
    "gravload",
    "itorque",
    "accel",
    "inertia",
)


@pytest.mark.parametrize("case", PUBLISHED)
def test_published_puma_numbers(published, case):
    """Corke, Robotics Toolbox unit tests; tolerance of the printed digits."""
    arm = load_arm("puma560")
    c = published["python"][case]
    q, qd = published["poses"][c["q"]], c.get("qd", [0.0] * 6)
    qdd = c.get("qdd", [0.0] * 6)
    if "gravity" in c:
        arm = arm.with_gravity(c["gravity"])
    if case == "accel":
        found = arm.forward_dynamics(q, qd, c["tau"], friction=True)
    elif case == "inertia":
        found = arm.mass_matrix(q)
    elif case == "itorque":
        found = arm.mass_matrix(q) @ qdd
    elif case == "rne_fext":
        found = arm.inverse_dynamics(q, qd, qdd, wrench=c["fext_tip_frame"], wrench_frame="tool", friction=False)
    elif case == "gravload":
        found = arm.gravity(q)
    else:
        found = arm.inverse_dynamics(q, qd, qdd, friction=True)
    np.testing.assert_allclose(found, c["value"], atol=published["tol"])


@pytest.mark.oracle
def test_against_pinocchio():
    """The same chain built in Pinocchio: an independent implementation, to rounding."""
    pin = pytest.importorskip("pinocchio", reason="Pinocchio is not installed (extra 'oracle')")
    arm = load_arm("puma560")
    model = pinocchio_model(pin, arm)
    data = model.createData()
    rng = np.random.default_rng(8)
    for _ in range(20):
        q, qd, qdd = rng.uniform(-3, 3, (3, 6))
        tau = pin.rnea(model, data, q, qd, qdd)
        np.testing.assert_allclose(
            arm.inverse_dynamics(q, qd, qdd, friction=False), tau, atol=1e-10 * np.abs(tau).max()
        )
        np.testing.assert_allclose(arm.forward_dynamics(q, qd, tau, friction=False), qdd, atol=1e-9)
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        np.testing.assert_allclose(arm.mass_matrix(q), M, atol=1e-10)


def test_errors_name_the_cause():
    arm = load_arm("puma560")
    z = np.zeros(6)
    with pytest.raises(ShapeError, match=r"qd has shape \(5,\)"):
        arm.inverse_dynamics(z, z[:5], z)
    with pytest.raises(ShapeError, match="nan"):
        arm.gravity([0.0, np.nan, 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(InputError, match="wrench_frame"):
        arm.inverse_dynamics(z, z, z, wrench=z)
    with pytest.raises(UnknownName, match="world"):
        arm.inverse_dynamics(z, z, z, wrench=z, wrench_frame="base2")
    bare = arm_from_dh([DHRow(a=1.0), DHRow(a=1.0)], convention="standard", name="bare")
    bare.fk([0.1, 0.2])
    with pytest.raises(MissingInertia, match="bare"):
        bare.gravity([0.1, 0.2])
    with pytest.raises(UnknownName, match="did you mean 'puma560'"):
        load_arm("puma56")
