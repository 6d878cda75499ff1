"""Derivatives of the dynamics and of the Jacobian: the recursion against the graph, differences and Pinocchio."""

import dataclasses

import numpy as np
import pytest
from arms import presets, random_model, random_tree
from scipy.spatial.transform import Rotation

from holonom.errors import MissingInertia, UnknownName
from holonom.mechanics import Arm, arm_from_dh, load_arm
from holonom.mechanics.dynamics import forward_dynamics_derivatives, inverse_dynamics_derivatives
from holonom.mechanics.equations.dynamics import derivatives, newton_euler
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.jacobians import acceleration_bias, analytic_jacobian, jacobian_hessian, jacobian_rate
from holonom.mechanics.kernels.table import bodies_of
from holonom.model import DHRow, Friction, Motor
from holonom.spatial import rpy_angles, zyz_angles
from holonom.trace import Graph, Scalar
from holonom.trace.derivative import jacobian
from holonom.trace.line.straight import operand, straight_line


def rubbing(model):
    """The model with friction of every kind and rotors on its joints."""
    friction = Friction(0.3, 0.5, 0.7, static_ratio=1.6, stribeck_speed=0.4)
    joints = [dataclasses.replace(j, friction=friction, motor=Motor(-30.0, 2e-4)) for j in model.joints]
    return dataclasses.replace(model, joints=tuple(joints))


MODELS = [arm.model for arm in presets() if arm.model.bodies is not None]
MODELS += [rubbing(random_model(seed, n)) for seed, n in ((1, 2), (2, 4), (4, 7))]
MODELS += [rubbing(random_tree(seed, n)) for seed, n in ((5, 4), (6, 7))]
NAMES = [m.name for m in MODELS]


def motion(model, seed):
    return np.random.default_rng(seed).uniform(-1.5, 1.5, (3, len(model.independent)))


def differences(f, x, h=1e-5):
    """Derivatives of f by central differences of fourth order, column by column."""
    steps = h * np.eye(len(x))
    columns = [(8 * (f(x + e) - f(x - e)) - (f(x + 2 * e) - f(x - 2 * e))) / (12 * h) for e in steps]
    return np.stack(columns, axis=-1)


def floats(rows):
    return np.array(rows, dtype=float)


@pytest.mark.parametrize("model", MODELS, ids=NAMES)
def test_inverse_dynamics_derivatives_are_its_differences(model):
    x, bodies = motion(model, 1), bodies_of(model)
    found = derivatives.inverse_dynamics_derivatives(model, bodies, *x.tolist(), friction=True)
    for k in range(3):

        def torque(v, k=k):
            state = [*x[:k], v, *x[k + 1 :]]
            return floats(newton_euler.inverse_dynamics(model, bodies, *(s.tolist() for s in state), friction=True))

        expected = differences(torque, x[k])
        np.testing.assert_allclose(floats(found[k]), expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("model", MODELS, ids=NAMES)
def test_forward_dynamics_derivatives_are_its_differences(model):
    (q, qd, qdd), bodies = motion(model, 2), bodies_of(model)
    tau = floats(newton_euler.inverse_dynamics(model, bodies, q.tolist(), qd.tolist(), qdd.tolist(), friction=True))
    x = (q, qd, tau)
    found = derivatives.forward_dynamics_derivatives(model, bodies, *(v.tolist() for v in x), friction=True)
    for k in range(3):

        def acceleration(v, k=k):
            state = [*x[:k], v, *x[k + 1 :]]
            return floats(forward_dynamics(model, bodies, *(s.tolist() for s in state), friction=True))

        expected = differences(acceleration, x[k])
        np.testing.assert_allclose(floats(found[k]), expected, rtol=2e-7, atol=2e-7 * np.abs(expected).max())


@pytest.mark.parametrize("model", [load_arm("puma560").model, MODELS[-2]], ids=["puma560", MODELS[-2].name])
def test_recursion_is_what_the_graph_gives(model):
    """Newton-Euler differentiated on its graph shares nothing with the recursion; the graph is run on floats."""
    graph = Graph()
    n = len(model.independent)
    inputs = [graph.input(name, k) for name in ("q", "qd", "qdd") for k in range(n)]
    tau = newton_euler.inverse_dynamics(
        model, bodies_of(model), inputs[:n], inputs[n : 2 * n], inputs[2 * n :], friction=True
    )
    x = motion(model, 3)
    J = run_graph(graph, [entry for row in jacobian(tau, inputs) for entry in row], inputs, x.ravel())
    J = np.reshape(J, (n, 3, n))
    found = derivatives.inverse_dynamics_derivatives(model, bodies_of(model), *x.tolist(), friction=True)
    for k in range(3):
        np.testing.assert_allclose(floats(found[k]), J[:, k], atol=1e-12 * np.abs(J[:, k]).max())


def run_graph(graph, outputs, inputs, values):
    """Evaluate scalars of a graph with plain Python floats."""
    outputs = [y if isinstance(y, Scalar) else graph.constant(y) for y in outputs]
    scope = {operand(graph, x.i): float(v) for x, v in zip(inputs, values, strict=True)} | {
        "select": lambda c, a, b: a if c else b,
        "sincos": lambda x: (np.sin(x), np.cos(x)),
    }
    exec("\n".join(straight_line(graph, outputs)), scope)
    return [eval(operand(graph, y.i), scope) for y in outputs]


COMPILED = rubbing(random_tree(5, 4))


def test_compiled_equals_floats():
    arm, bodies, x = Arm(COMPILED), bodies_of(COMPILED), motion(COMPILED, 3)
    expected = derivatives.inverse_dynamics_derivatives(arm.model, bodies, *x.tolist(), friction=True)
    found = inverse_dynamics_derivatives(arm, *x)
    batch = inverse_dynamics_derivatives(arm, *(np.tile(v, (70, 1)) for v in x), threads=2)
    for a, b, c in zip(found, batch, expected, strict=True):
        np.testing.assert_allclose(a, floats(c), atol=1e-12 * np.abs(a).max())
        np.testing.assert_allclose(b, np.tile(floats(c), (70, 1, 1)), atol=1e-12 * np.abs(a).max())
    np.testing.assert_allclose(found.dtau_dqdd, arm.mass_matrix(x[0]), atol=1e-11)


def test_compiled_forward_dynamics_derivatives():
    arm, bodies, x = Arm(COMPILED), bodies_of(COMPILED), motion(COMPILED, 4)
    expected = derivatives.forward_dynamics_derivatives(arm.model, bodies, *x.tolist(), friction=True)
    found = forward_dynamics_derivatives(arm, *x)
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a, floats(b), atol=1e-10 * np.abs(floats(b)).max())
    np.testing.assert_allclose(found.dqdd_dtau @ arm.mass_matrix(x[0]), np.eye(arm.n), atol=1e-9)


def test_friction_may_be_left_out_and_results_go_where_told():
    arm = Arm(rubbing(random_model(1, 2)))
    x = motion(arm.model, 5)
    out = tuple(np.empty((2, 2)) for _ in range(3))
    free = inverse_dynamics_derivatives(arm, *x, friction=False, out=out)
    assert free.dtau_dqd is out[1]
    difference = inverse_dynamics_derivatives(arm, *x).dtau_dqd - free.dtau_dqd
    slopes = [newton_euler.friction_slope(j.friction, u) for j, u in zip(arm.model.joints, x[1], strict=True)]
    np.testing.assert_allclose(difference, np.diag(slopes), atol=1e-12)


@pytest.mark.parametrize("frame", ["world", "tool"])
def test_jacobian_derivatives(frame):
    arm = Arm(random_model(2, 4) if frame == "world" else random_tree(5, 4))
    q, qd, _ = motion(arm.model, 6)
    H = jacobian_hessian(arm, q, frame)
    expected = differences(lambda v: arm.jacobian(v, frame), q)
    np.testing.assert_allclose(H, expected, atol=1e-9)
    rate = jacobian_rate(arm, q, qd, frame)
    np.testing.assert_allclose(rate, H @ qd, atol=1e-12)
    np.testing.assert_allclose(acceleration_bias(arm, q, qd, frame), rate @ qd, atol=1e-12)


@pytest.mark.parametrize("angles", ["zyz", "rpy"])
def test_analytic_jacobian_is_the_rate_of_position_and_angles(angles):
    arm = load_arm("puma560")
    q, _, _ = motion(arm.model, 7)
    read = {"zyz": zyz_angles, "rpy": rpy_angles}[angles]

    def task(v):
        T = arm.fk(v)
        return np.array([*T[:3, 3], *read(T[:3, :3]).angles[0]])

    found = analytic_jacobian(arm, np.tile(q, (3, 1)), angles=angles)
    assert not found.degenerate.any()
    np.testing.assert_allclose(found.J[1], differences(task, q), atol=1e-8)


def test_degenerate_angles_are_said():
    arm = load_arm("puma560")
    for angles, upright in (("zyz", np.eye(3)), ("rpy", Rotation.from_euler("y", np.pi / 2).as_matrix())):
        q = np.zeros(6)
        turn = np.eye(4)
        turn[:3, :3] = arm.fk(q)[:3, :3].T @ upright
        found = analytic_jacobian(arm.with_tool(turn), q, angles=angles)
        assert found.degenerate
        assert np.isfinite(found.J).all()
        np.testing.assert_array_equal(found.J[3:] if angles == "zyz" else found.J[[3, 5]], 0.0)
        np.testing.assert_allclose(found.J[:3], arm.with_tool(turn).jacobian(q)[:3], atol=1e-14)


def test_errors_name_the_cause():
    arm = load_arm("puma560")
    with pytest.raises(UnknownName, match="zyz"):
        analytic_jacobian(arm, np.zeros(6), angles="xyz")
    with pytest.raises(UnknownName, match="tool"):
        jacobian_hessian(arm, np.zeros(6), "flange")
    bare = arm_from_dh([DHRow(a=1.0)], convention="standard", name="bare")
    with pytest.raises(MissingInertia, match="bare"):
        inverse_dynamics_derivatives(bare, [0.1], [0.1], [0.1])


@pytest.mark.oracle
@pytest.mark.parametrize("seed", [None, 1, 4])
def test_against_pinocchio(pinocchio, seed):
    pin = pinocchio
    from peers import pinocchio_model

    arm = load_arm("puma560") if seed is None else Arm(random_model(seed, 5))
    bodies = bodies_of(arm.model)
    model = pinocchio_model(pin, arm)
    data = model.createData()
    for k in range(5):
        q, qd, x = motion(arm.model, 10 + k)
        ours = derivatives.inverse_dynamics_derivatives(arm.model, bodies, q.tolist(), qd.tolist(), x.tolist())
        pin.computeRNEADerivatives(model, data, q, qd, x)
        M = np.triu(data.M) + np.triu(data.M, 1).T
        for a, b in zip(ours, (data.dtau_dq, data.dtau_dv, M), strict=True):
            np.testing.assert_allclose(floats(a), b, atol=1e-10 * np.abs(b).max())
        ours = derivatives.forward_dynamics_derivatives(arm.model, bodies, q.tolist(), qd.tolist(), x.tolist())
        theirs = pin.computeABADerivatives(model, data, q, qd, x)
        for a, b in zip(ours, theirs, strict=True):
            whole = np.triu(b) + np.triu(b, 1).T if b is theirs[2] else b
            np.testing.assert_allclose(floats(a), whole, atol=1e-10 * np.abs(whole).max())
