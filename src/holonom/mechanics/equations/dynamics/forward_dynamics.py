"""Forward dynamics: B(q) qdd = tau - h(q, qd), solved by B = U D U^T, or by articulated bodies for long chains.

No square root and no pivoting: B is positive definite.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.dynamics.articulated_body import solve_inertia
from holonom.mechanics.equations.dynamics.composite_body import MANY, mass_matrix
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.newton_euler import inverse_dynamics
from holonom.mechanics.equations.vectors import Matrix, Vector, sub
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["factor_ldl", "forward_dynamics", "solve_factored", "solve_ldl"]


def factor_ldl(B: Matrix) -> list[list[Number]]:
    """Factor a symmetric positive definite B = U D U^T, U with ones on its diagonal and zeros below.

    Row k is what stands above the diagonal in column k of U, then 1 / D[k]. Eliminated from the last row up: an arm's
    distal rows are the cheap ones, and zeros of B stay zeros.
    """
    A = [list(row) for row in B]
    factor: list[list[Number]] = [[] for _ in A]
    for k in reversed(range(len(A))):
        inverse = 1.0 / A[k][k]
        factor[k] = [*(A[k][i] * inverse for i in range(k)), inverse]
        for i in range(k):
            for j in range(i + 1):
                A[i][j] = A[i][j] - factor[k][i] * A[k][j]
    return factor


def solve_factored(factor: Matrix, b: Vector) -> list[Number]:
    """Solve B x = b, given `factor_ldl(B)`."""
    x = list(b)
    for i in reversed(range(len(x))):
        for k in reversed(range(i + 1, len(x))):
            x[i] = x[i] - factor[k][i] * x[k]
    for k, row in enumerate(factor):
        x[k] = x[k] * row[k]
        for i in range(k):
            x[k] = x[k] - row[i] * x[i]
    return x


def solve_ldl(B: Matrix, b: Vector) -> list[Number]:
    """Solve B x = b for a symmetric positive definite B."""
    return solve_factored(factor_ldl(B), b)


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
