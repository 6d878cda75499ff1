"""The equations on floats, as arrays: what an arm computes without compiling anything."""

from __future__ import annotations

import numpy as np

from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import composite_body, newton_euler
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.kernels.table import bodies_of


def array(values) -> np.ndarray:
    return np.array(values, dtype=float)


def fk(model, q):
    return array(kinematics.pose(model, list(q), None)).reshape(4, 4)


def jacobian(model, q, frame="world"):
    return array(kinematics.jacobian(model, list(q), frame)).reshape(6, -1)


def mass_matrix(model, q):
    return array(composite_body.mass_matrix(model, bodies_of(model), list(q)))


def inverse_dynamics(model, q, qd, qdd):
    return array(newton_euler.inverse_dynamics(model, bodies_of(model), list(q), list(qd), list(qdd)))


def qdd_of(model, q, qd, tau):
    return array(forward_dynamics(model, bodies_of(model), list(q), list(qd), list(tau)))
