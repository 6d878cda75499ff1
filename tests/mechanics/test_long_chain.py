"""Long chains: what is made in columns, and the regressor in one frame, against the equations as they stand."""

import numpy as np
import pytest
from arms import random_model, random_tree
from test_derivatives import floats, motion, rubbing

from holonom.mechanics import Arm
from holonom.mechanics.dynamics import christoffel, coupling_table, forward_dynamics_derivatives
from holonom.mechanics.equations.dynamics import coriolis, derivatives, newton_euler, regressor
from holonom.mechanics.kernels.table import bodies_of


def composition(model, q, qd, tau, friction):
    """-B^-1 dtau/dq, -B^-1 dtau/dqd and B^-1 where the torques act, from the equations on floats and LAPACK."""
    bodies, still = bodies_of(model), [0.0] * len(q)
    B = floats(derivatives.inverse_dynamics_derivatives(model, bodies, q.tolist(), still, still).last)
    bias = newton_euler.inverse_dynamics(model, bodies, q.tolist(), qd.tolist(), still, friction=friction)
    x = (q.tolist(), qd.tolist(), np.linalg.solve(B, tau - floats(bias)).tolist())
    found = derivatives.inverse_dynamics_derivatives(model, bodies, *x, friction=friction)
    return -np.linalg.solve(B, floats(found.q)), -np.linalg.solve(B, floats(found.qd)), np.linalg.inv(B)


def check_derivatives(model, counts, friction):
    arm, n = Arm(model), len(model.independent)
    q, qd, tau = np.random.default_rng(n).uniform(-1.5, 1.5, (3, max(*counts, 1), n))
    expected = [composition(model, *x, friction) for x in zip(q, qd, tau, strict=True)]
    for count in counts:
        x = (q[0], qd[0], tau[0]) if count == 0 else (q[:count], qd[:count], tau[:count])
        found = forward_dynamics_derivatives(arm, *x, friction=friction)
        for k in range(3):
            wanted = np.array([e[k] for e in expected[: count or 1]]).reshape(found[k].shape)
            np.testing.assert_allclose(found[k], wanted, rtol=1e-9, atol=1e-10 * np.abs(wanted).max())


def test_forward_dynamics_derivatives_in_columns():
    """One sample (0), then batches that fill no vector, one, and more."""
    check_derivatives(rubbing(random_model(13, 13)), range(21), False)


def test_thirty_joints():
    """One sample: to compile a batch as well would show nothing that shorter chains do not."""
    check_derivatives(rubbing(random_model(0, 30)), [0], True)


def test_columns_of_a_tree(monkeypatch):
    """Branches, and a joint that follows another one."""
    monkeypatch.setattr("holonom.mechanics.kernels.dynamics.MANY", 2)
    model = rubbing(random_tree(6, 7))
    assert Arm(model).kernel("forward_dynamics_derivatives").columns is not None
    check_derivatives(model, [0, 5], True)


@pytest.mark.parametrize("model", [random_model(3, 5), random_tree(5, 5)], ids=["chain", "tree"])
def test_christoffel_symbols_in_columns(model, monkeypatch):
    monkeypatch.setattr("holonom.mechanics.kernels.dynamics.MANY_SYMBOLS", 2)
    arm, q = Arm(model), motion(model, 1)
    assert arm.kernel("christoffel").columns is not None
    for x in (q[0], q):
        c, table = christoffel(arm, x), coupling_table(arm, x)
        expected = floats([coriolis.christoffel(model, bodies_of(model), each.tolist()) for each in np.atleast_2d(x)])
        np.testing.assert_allclose(c, expected.reshape(c.shape), atol=1e-12 * np.abs(expected).max())
        np.testing.assert_allclose(table.gravity, arm.gravity(x), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(table.inertia, arm.mass_matrix(x), rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(table.centrifugal, np.einsum("...ijj->...ij", c), atol=1e-12)
        np.testing.assert_allclose(table.coriolis, c * (1.0 - np.eye(arm.n)), atol=1e-12)


@pytest.mark.parametrize("model", [random_model(1, 13), rubbing(random_tree(3, 14))], ids=["chain", "tree"])
def test_regressor_in_one_frame(model, monkeypatch):
    """That of link frames, which takes fewer operations for short chains."""
    x = motion(model, 2).tolist()
    found = regressor.regressor(model, *x)
    monkeypatch.setattr(regressor, "MANY", 99)
    expected = regressor.regressor(model, *x)
    np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
