"""Kernels of `mechanics.dynamics`: derivatives, Coriolis terms, energies.

With the full rotor model the derivatives come from the graph of the inverse dynamics, else from their own recursion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from holonom.mechanics.equations.dynamics import composite_body, coriolis, derivatives, energy, newton_euler
from holonom.mechanics.equations.dynamics.derivatives import Derivatives
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.vectors import Matrix, Vector, matmul, matvec, scale, transpose
from holonom.mechanics.kernels.placement import Here, compile_here
from holonom.mechanics.kernels.results import (
    CouplingTable,
    Energy,
    ForwardDynamicsDerivatives,
    InverseDynamicsDerivatives,
)
from holonom.model import ArmModel
from holonom.numeric.small import solve_ldl
from holonom.trace import Kernel, Number, Scalar
from holonom.trace.derivative import jacobian

__all__ = ["DYNAMICS", "WITH_FRICTION"]

Options = Mapping[str, Any]
MANY = 12
"""Joints from which on the columns of a result are a loop."""
MANY_SYMBOLS = 20
"""The same of Christoffel symbols: a loop cannot make use of zeros and symmetry, and takes more operations."""


def _flat(rows: Matrix) -> list[Number]:
    return [entry for row in rows for entry in row]


def _scalars(values: Vector) -> list[Scalar]:
    return [v for v in values if isinstance(v, Scalar)]


def _inverse_derivatives(model: ArmModel, options: Options) -> Kernel:
    friction = options["friction"]

    def equation(here: Here, q: Vector, qd: Vector, qdd: Vector) -> list[list[Number]]:
        model, bodies = here.model, here.bodies
        if model.rotors == "full":
            found = _by_graph(model, bodies, q, qd, qdd, friction)
        else:
            found = derivatives.inverse_dynamics_derivatives(model, bodies, q, qd, qdd, friction=friction)
        return [_flat(rows) for rows in found]

    n = len(model.independent)
    outputs = {"dtau_dq": (n, n), "dtau_dqd": (n, n), "dtau_dqdd": (n, n)}
    return compile_here(
        model,
        options,
        equation,
        {"q": n, "qd": n, "qdd": n},
        outputs,
        name="inverse_dynamics_derivatives",
        result=InverseDynamicsDerivatives,
    )


def _by_graph(
    model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, qdd: Vector, friction: bool
) -> Derivatives:
    tau = newton_euler.inverse_dynamics(model, bodies, q, qd, qdd, friction=friction)
    rows = jacobian(tau, _scalars([*q, *qd]))
    n = len(q)
    by_speed = [row[n:] for row in rows]
    return Derivatives([row[:n] for row in rows], by_speed, composite_body.mass_matrix(model, bodies, q))


def _forward_derivatives(model: ArmModel, options: Options) -> Kernel:
    friction, n = options["friction"], len(model.independent)
    in_columns = n >= MANY and model.rotors == "reflected"

    def equation(here: Here, q: Vector, qd: Vector, tau: Vector) -> Sequence[Vector]:
        model, bodies = here.model, here.bodies
        if in_columns:
            return derivatives.forward_dynamics_columns(model, bodies, q, qd, tau, friction=friction)
        if model.rotors == "full":
            found = _forward_by_graph(model, bodies, q, qd, tau, friction)
        else:
            found = derivatives.forward_dynamics_derivatives(model, bodies, q, qd, tau, friction=friction)
        return [_flat(rows) for rows in found]

    return compile_here(
        model,
        options,
        equation,
        {"q": n, "qd": n, "tau": n},
        {"dqdd_dq": (n, n), "dqdd_dqd": (n, n), "dqdd_dtau": (n, n)},
        name="forward_dynamics_derivatives",
        columns=derivatives.forward_dynamics_column if in_columns else None,
        result=ForwardDynamicsDerivatives,
        checked=not in_columns,
    )


def _forward_by_graph(
    model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, tau: Vector, friction: bool
) -> Derivatives:
    """The accelerations count as given while the torques are differentiated: they enter them linearly, through B."""
    still = [0.0] * len(q)
    B = composite_body.mass_matrix(model, bodies, q)
    qdd = forward_dynamics(model, bodies, q, qd, tau, friction=friction)
    bias = newton_euler.inverse_dynamics(model, bodies, q, qd, still, friction=friction)
    by_state = jacobian(bias, _scalars([*q, *qd]))
    by_inertia = [jacobian(row, _scalars(q)) for row in B]
    n = len(q)
    by_q = [[by_state[i][k] + _dot([by_inertia[i][j][k] for j in range(n)], qdd) for k in range(n)] for i in range(n)]
    inverse = transpose([solve_ldl(B, [float(i == k) for i in range(n)]) for k in range(n)])
    minus = [scale(-1.0, row) for row in inverse]
    return Derivatives(matmul(minus, by_q), matmul(minus, [row[n:] for row in by_state]), inverse)


def _dot(a: Vector, b: Vector) -> Number:
    return matvec([a], b)[0]


def _coriolis_rows(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector) -> list[list[Number]]:
    if model.rotors == "reflected":
        return coriolis.coriolis_matrix(model, bodies, q, qd)
    still, weightless = [0.0] * len(q), [0.0, 0.0, 0.0]
    bias = newton_euler.inverse_dynamics(model, bodies, q, qd, still, gravity=weightless)
    return [scale(0.5, row) for row in jacobian(bias, _scalars(qd))]  # the bias is quadratic in qd


def _coriolis(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)
    return compile_here(
        model,
        options,
        lambda here, q, qd: _flat(_coriolis_rows(here.model, here.bodies, q, qd)),
        {"q": n, "qd": n},
        {"C": (n, n)},
        name="coriolis_matrix",
    )


def _christoffel(model: ArmModel, options: Options) -> Kernel:
    n, in_columns = len(model.independent), _symbols_in_columns(model)

    def equation(here: Here, q: Vector) -> Sequence[Any]:
        model, bodies = here.model, here.bodies
        if in_columns:
            return coriolis.christoffel_columns(model, bodies, q)
        return [c for layer in _symbols(model, bodies, q) for c in _flat(layer)]

    return compile_here(
        model,
        options,
        equation,
        {"q": n},
        {"c": (n, n, n)},
        name="christoffel",
        columns=(lambda shared, own: _flat(coriolis.christoffel_column(model, shared, own))) if in_columns else None,
    )


def _symbols_in_columns(model: ArmModel) -> bool:
    return len(model.independent) >= MANY_SYMBOLS and model.rotors == "reflected"


def _symbols(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> Sequence[Matrix]:
    if model.rotors == "reflected":
        return coriolis.christoffel(model, bodies, q)
    slope = [jacobian(row, _scalars(q)) for row in composite_body.mass_matrix(model, bodies, q)]
    places = range(len(q))
    return [
        [[0.5 * (slope[i][j][k] + slope[i][k][j] - slope[j][k][i]) for k in places] for j in places] for i in places
    ]


def _coupling_table(model: ArmModel, options: Options) -> Kernel:
    """D_i, D_ij, D_ijj, and D_ijk with zeros for j = k."""
    n, in_columns = len(model.independent), _symbols_in_columns(model)
    places = range(n)

    def equation(here: Here, q: Vector) -> Sequence[Vector]:
        model, bodies = here.model, here.bodies
        gravity = newton_euler.inverse_dynamics(model, bodies, q, [0.0] * n, [0.0] * n)
        B = _flat(composite_body.mass_matrix(model, bodies, q))
        if in_columns:
            shared, unit = coriolis.christoffel_columns(model, bodies, q)
            return shared, [*unit, *gravity, *B]
        c = _symbols(model, bodies, q)
        return [
            gravity,
            B,
            [c[i][j][j] for i in places for j in places],
            [0.0 if j == k else c[i][j][k] for i in places for j in places for k in places],
        ]

    def column(shared: Vector, own: Vector) -> Sequence[Vector]:
        unit, gravity, B = own[:n], own[n : n + 1], own[n + 1 :]
        c = coriolis.christoffel_column(model, shared, unit)
        return [gravity, B, matvec(c, unit), [c[i][j] * (1.0 - unit[j]) for i in places for j in places]]

    outputs: dict[str, int | tuple[int, ...]] = {"gravity": n, "B": (n, n), "D2": (n, n), "D3": (n, n, n)}
    columns = column if in_columns else None
    return compile_here(
        model, options, equation, {"q": n}, outputs, name="coupling_table", columns=columns, result=CouplingTable
    )


def _bias(model: ArmModel, options: Options) -> Kernel:
    n, friction = len(model.independent), options["friction"]
    return compile_here(
        model,
        options,
        lambda here, q, qd: newton_euler.inverse_dynamics(here.model, here.bodies, q, qd, [0.0] * n, friction=friction),
        {"q": n, "qd": n},
        {"h": n},
        name="bias",
    )


def _energy(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)

    def equation(here: Here, q: Vector, qd: Vector) -> list[list[Number]]:
        model, bodies = here.model, here.bodies
        return [[energy.kinetic_energy(model, bodies, q, qd)], [energy.potential_energy(model, bodies, q)]]

    return compile_here(
        model,
        options,
        equation,
        {"q": n, "qd": n},
        {"kinetic": (), "potential": ()},
        name="energy",
        result=Energy,
    )


def _momentum(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)
    return compile_here(
        model,
        options,
        lambda here, q, qd: energy.momentum(here.model, here.bodies, q, qd),
        {"q": n, "qd": n},
        {"p": n},
        name="momentum",
    )


def _centroidal_momentum(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)
    return compile_here(
        model,
        options,
        lambda here, q, qd: energy.centroidal_momentum(here.model, here.bodies, q, qd),
        {"q": n, "qd": n},
        {"h": 6},
        name="centroidal_momentum",
    )


def _centre_of_mass(model: ArmModel, options: Options) -> Kernel:
    return compile_here(
        model,
        options,
        lambda here, q: energy.centre_of_mass(here.model, here.bodies, q),
        {"q": len(model.independent)},
        {"c": 3},
        name="centre_of_mass",
    )


DYNAMICS: Mapping[str, Callable[[ArmModel, Options], Kernel]] = {
    "inverse_dynamics_derivatives": _inverse_derivatives,
    "forward_dynamics_derivatives": _forward_derivatives,
    "coriolis_matrix": _coriolis,
    "christoffel": _christoffel,
    "coupling_table": _coupling_table,
    "bias": _bias,
    "energy": _energy,
    "momentum": _momentum,
    "centroidal_momentum": _centroidal_momentum,
    "centre_of_mass": _centre_of_mass,
}
WITH_FRICTION = ("inverse_dynamics_derivatives", "forward_dynamics_derivatives", "bias")
"""Those that joint friction may be in."""
