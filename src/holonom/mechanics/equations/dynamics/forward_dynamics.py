"""Forward dynamics: B(q) qdd = tau - h(q, qd), solved by B = U D U^T, or by articulated bodies for long chains.

No square root and no pivoting: B is positive definite.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.dynamics.articulated_body import solve_inertia
from holonom.mechanics.equations.dynamics.composite_body import MANY, mass_matrix
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.newton_euler import inverse_dynamics
from holonom.mechanics.equations.vectors import Vector, sub
from holonom.model import ArmModel
from holonom.numeric.small import solve_ldl
from holonom.trace import Number

__all__ = ["forward_dynamics"]


def forward_dynamics(
    model: ArmModel,
    bodies: Sequence[Inertial],
    q: Vector,
    qd: Vector,
    tau: Vector,
    *,
    friction: bool = False,
    wrench_tool: Vector | None = None,
) -> list[Number]:
    """Joint accelerations under joint torques."""
    still = [0.0] * len(model.independent)
    bias = inverse_dynamics(model, bodies, q, qd, still, friction=friction, wrench_tool=wrench_tool)
    uncoupled = len(model.independent) == len(model.joints) and model.rotors == "reflected"
    if uncoupled and len(model.joints) >= MANY:
        return solve_inertia(model, bodies, q, sub(tau, bias))
    return solve_ldl(mass_matrix(model, bodies, q), sub(tau, bias))
