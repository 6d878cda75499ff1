"""Builders of the kernels that the numerical inverse calls: the task at q, and a criterion with its gradient."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

from holonom.errors import UnknownName
from holonom.mechanics.equations.criteria import CRITERIA, Criterion
from holonom.mechanics.equations.pose_task import damped_multipliers, pose_task
from holonom.mechanics.equations.vectors import Vector
from holonom.mechanics.kernels.placement import Here, compile_here
from holonom.model import ArmModel
from holonom.trace import Kernel, Number, Scalar, compile
from holonom.trace.derivative import jacobian

__all__ = ["criterion", "multipliers_kernel", "task"]

Options = Mapping[str, Any]


def task(model: ArmModel, options: Options) -> Kernel:
    """Trace q, goal, weights -> residual, e, J^T, J J^T of `equations.pose_task`."""
    n, frame, exact = len(model.independent), options["frame"], options["exact"]

    def equation(here: Here, q: Vector, goal: Vector, weights: Vector) -> list[Number]:
        return pose_task(here.model, q, goal, weights, frame, exact)

    inputs, name = {"q": n, "goal": 12, "weights": 6}, f"pose_task_{frame}{'_exact' if exact else ''}"
    return compile_here(model, options, equation, inputs, {"task": 28 + 6 * n}, name=name)


@functools.cache
def multipliers_kernel() -> Kernel:
    """Return the kernel normal, x, damping -> y of `damped_multipliers`: one for every arm."""
    return compile(
        lambda normal, x, damping: damped_multipliers(normal, x, damping[0]),
        {"normal": 21, "x": 6, "damping": 1},
        {"y": 6},
        name="damped_multipliers",
    )


def criterion(model: ArmModel, options: Options) -> Kernel:
    """Trace q, preferred -> H and dH/dq of a criterion: a name of the table or a function like those in it."""
    chosen: str | Criterion = options["criterion"]
    if isinstance(chosen, str) and chosen not in CRITERIA:
        raise UnknownName("criterion", chosen, CRITERIA)
    function = CRITERIA[chosen] if isinstance(chosen, str) else chosen
    n = len(model.independent)

    def equation(here: Here, q: Sequence[Scalar], preferred: Sequence[Scalar]) -> tuple[list[Number], list[Number]]:
        value = function(here.model, q, preferred)
        return [value], jacobian([value], q, "reverse")[0]

    name = chosen if isinstance(chosen, str) else "".join(c for c in function.__name__ if c.isalnum() or c == "_")
    outputs = {"H": 1, "slope": n}
    return compile_here(model, options, equation, {"q": n, "preferred": n}, outputs, name=f"criterion_{name}")
