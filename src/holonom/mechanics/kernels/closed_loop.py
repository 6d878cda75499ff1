"""Kernels of `mechanics.simulate`: an arm under a law, and what decides whether its joints stick."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from holonom.mechanics.equations.dynamics.closed_loop import (
    LAWS,
    breakaway,
    closed_loop,
    parameter_fields,
    parts_of,
    varied_bodies,
    width_of,
)
from holonom.mechanics.equations.dynamics.composite_body import mass_matrix
from holonom.mechanics.equations.vectors import Vector
from holonom.mechanics.kernels.placement import GIVEN, Here, bodies_of, placed
from holonom.model import ArmModel
from holonom.trace import Kernel, Number, compile

__all__ = ["closed_loop_kernel", "fields_of", "stiction_kernel"]

Options = Mapping[str, Any]


def fields_of(model: ArmModel, options: Options) -> dict[str, int]:
    """Names and widths of all parameters; where the arm stands comes last, each as `at_base` and so on."""
    return parameter_fields(model, options) | {
        f"at_{name}": math.prod(GIVEN[name]) for name in options.get("given", ())
    }


def _here(model: ArmModel, options: Options, part: Mapping[str, Vector]) -> Here:
    given = {name: part[f"at_{name}"] for name in options.get("given", ())}
    return placed(model, given) if given else Here(model)


def closed_loop_kernel(model: ArmModel, options: Options) -> Kernel:
    """Compile `closed_loop`: inputs q, qd, slip (n), reference, parameters; outputs qdd, tau (n).

    Options: law (a name in `LAWS`), varied (among "payload", "masses", "friction"), friction, wrench_frame, given
    (among `GIVEN`).
    """
    n, fields, _ = len(model.independent), fields_of(model, options), bodies_of(model)

    def equation(
        q: Vector, qd: Vector, slip: Vector, reference: Vector, parameters: Vector
    ) -> tuple[list[Number], list[Number]]:
        part = parts_of(fields, parameters)
        here = _here(model, options, part)
        return closed_loop(here.model, here.bodies, options, (q, qd), reference, part, slip)

    inputs = {
        "q": n,
        "qd": n,
        "slip": n,
        "reference": LAWS[options["law"]].reference * n,
        "parameters": width_of(fields),
    }
    return compile(equation, inputs, {"qdd": n, "tau": n}, name=f"{model.name}_closed_loop_{options['law']}")


def stiction_kernel(model: ArmModel, options: Options) -> Kernel:
    """Compile what decides whether joints stick: q, qd (n), parameters -> B (n, n), `breakaway` (2 n) of the plant."""
    n, fields = len(model.independent), fields_of(model, options)

    def equation(q: Vector, qd: Vector, parameters: Vector) -> list[list[Number]]:
        part = parts_of(fields, parameters)
        here = _here(model, options, part)
        B = mass_matrix(here.model, varied_bodies(here.model, here.bodies, part), q)
        return [[v for row in B for v in row], breakaway(here.model, qd, part)]

    inputs = {"q": n, "qd": n, "parameters": width_of(fields)}
    return compile(equation, inputs, {"B": (n, n), "breakaway": 2 * n}, name=f"{model.name}_stiction")
