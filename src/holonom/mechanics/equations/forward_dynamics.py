"""Forward dynamics: B(q) qdd = tau - h(q, qd), solved by B = L D L^T, or by articulated bodies for long chains.

No square root and no pivoting: B is positive definite.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.articulated_body import solve_inertia
from holonom.mechanics.equations.composite_body import MANY, mass_matrix
from holonom.mechanics.equations.inertia import Inertial
from holonom.mechanics.equations.newton_euler import inverse_dynamics
from holonom.mechanics.equations.vectors import Matrix, Vector, sub
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["forward_dynamics", "solve_ldl"]


def solve_ldl(B: Matrix, b: Vector) -> list[Number]:
    """Solve B x = b for a symmetric positive definite B.

    Eliminated from the last row up: an arm's distal rows are the cheap ones, and zeros of B stay zeros.
    """
    n = len(b)
    A = [list(row) for row in B]
    x = list(b)
    inverse: list[Number] = [0.0] * n
    factor: list[list[Number]] = [[0.0] * n for _ in range(n)]
    for k in reversed(range(n)):
        inverse[k] = 1.0 / A[k][k]
        for i in range(k):
            factor[k][i] = A[k][i] * inverse[k]
        for i in range(k):
            x[i] = x[i] - factor[k][i] * x[k]
            for j in range(i + 1):
                A[i][j] = A[i][j] - factor[k][i] * A[k][j]
    for k in range(n):
        x[k] = x[k] * inverse[k]
        for i in range(k):
            x[k] = x[k] - factor[k][i] * x[i]
    return x


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
