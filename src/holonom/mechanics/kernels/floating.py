"""Kernels of `mechanics.dynamics.floating`: an arm whose base moves, or is held by nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from holonom.errors import ModelError
from holonom.mechanics.equations.dynamics.composite_body import floating_mass_matrix
from holonom.mechanics.equations.dynamics.inertia import Inertial, from_body
from holonom.mechanics.equations.dynamics.newton_euler import on_moving_base
from holonom.mechanics.equations.vectors import Vector, sub
from holonom.mechanics.kernels.movable import check_movable
from holonom.mechanics.kernels.placement import Here, bodies_of, compile_here
from holonom.model import ArmModel
from holonom.numeric.small import solve_ldl
from holonom.trace import Kernel, Number

__all__ = ["FLOATING"]

Options = Mapping[str, Any]
NOTHING = Inertial(0.0, [0.0] * 3, [[0.0] * 3 for _ in range(3)])


def _base_body(model: ArmModel) -> Inertial:
    """What the base itself weighs.

    Raises
    ------
    MissingInertia, ModelError
        No masses; rotors whose coupling with the base has no equation.
    """
    bodies_of(model)
    if model.rotors == "full":
        raise ModelError(f"arm {model.name!r} has rotors='full', which is not there for a base that moves; with_rotors")
    return NOTHING if model.base_body is None else from_body(model.base_body)


def _inverse(model: ArmModel, options: Options) -> Kernel:
    n, base, friction = len(model.independent), _base_body(model), options["friction"]

    def equation(here: Here, q: Vector, qd: Vector, qdd: Vector, twist: Vector, acceleration: Vector) -> Any:
        return on_moving_base(here.model, here.bodies, base, (q, qd, qdd), twist, acceleration, friction=friction)

    inputs = {"q": n, "qd": n, "qdd": n, "twist": 6, "acceleration": 6}
    return compile_here(model, options, equation, inputs, {"wrench": 6, "tau": n}, name="floating_inverse")


def _forward(model: ArmModel, options: Options) -> Kernel:
    """B [acceleration; qdd] = [wrench; tau] - bias."""
    n, base, friction = len(model.independent), _base_body(model), options["friction"]
    check_movable(model, base)
    rest = [0.0] * n

    def equation(
        here: Here, q: Vector, qd: Vector, tau: Vector, twist: Vector, wrench: Vector, minus_gravity: Vector
    ) -> tuple[list[Number], list[Number]]:
        model, bodies = here.model, here.bodies
        lift = [*minus_gravity, 0.0, 0.0, 0.0]
        pull, bias = on_moving_base(model, bodies, base, (q, qd, rest), twist, lift, friction=friction)
        B = floating_mass_matrix(model, bodies, base, q)
        found = solve_ldl(B, [*sub(wrench, pull), *sub(tau, bias)])
        return found[:6], found[6:]

    inputs = {"q": n, "qd": n, "tau": n, "twist": 6, "wrench": 6, "minus_gravity": 3}
    outputs = {"acceleration": 6, "qdd": n}
    return compile_here(model, options, equation, inputs, outputs, name="floating_forward", checked=True)


def _mass_matrix(model: ArmModel, options: Options) -> Kernel:
    n, base = len(model.independent), _base_body(model)

    def equation(here: Here, q: Vector) -> list[Number]:
        return [v for row in floating_mass_matrix(here.model, here.bodies, base, q) for v in row]

    return compile_here(model, options, equation, {"q": n}, {"B": (6 + n, 6 + n)}, name="floating_mass_matrix")


FLOATING: Mapping[str, Callable[[ArmModel, Options], Kernel]] = {
    "floating_inverse": _inverse,
    "floating_forward": _forward,
    "floating_mass_matrix": _mass_matrix,
}
