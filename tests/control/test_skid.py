"""Twist of a base whose wheels skid: the balance of friction, solved otherwise."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from holonom.control.base.kernels import Planar
from holonom.control.base.skid_kernels import SkidParams, skid_twist

PLACES = np.array([[0.15, 0.2], [0.15, -0.2], [-0.12, 0.2], [-0.12, -0.2]])


@settings(max_examples=20, deadline=None)
@given(
    st.floats(-1.0, 1.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0),
    st.lists(st.floats(1.2, 2.0), min_size=4, max_size=4), st.floats(0.005, 0.05),
)  # fmt: skip
def test_friction_makes_the_acceleration(
    v: float, w: float, ax: float, ay: float, grip: list[float], soft: float
) -> None:
    """By minimising the dissipation directly; after the iterations of 60 ms."""
    g, com = np.array(grip), np.array([0.03, -0.02])
    rims = v - w * PLACES[:, 1] * 1.3
    params = SkidParams(np.column_stack([PLACES, g]), soft, *com)
    found = Planar(0.0, 0.0, 0.0)
    for _ in range(60):
        found = skid_twist(params, rims, found, w, ax, ay)
    a = np.array([ax, ay]) - w * w * com

    def dissipation(u: np.ndarray) -> float:
        along, across = rims - u[0] + w * PLACES[:, 1], -u[1] - w * PLACES[:, 0]
        return float((g * np.sqrt(along**2 + across**2 + soft**2)).sum() + a @ u)

    simplex = np.array([[v, 0.0], [v + 0.1, 0.0], [v, 0.1]])
    options = {"xatol": 1e-9, "fatol": 1e-13, "initial_simplex": simplex}
    best = minimize(dissipation, simplex[0], method="Nelder-Mead", options=options).x
    np.testing.assert_allclose(found[:2], best, atol=1e-4)
    assert found.turn == w
