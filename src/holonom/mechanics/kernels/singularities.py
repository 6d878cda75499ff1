"""Kernels of `mechanics.analysis`: manipulability, and measures of the singularities that have names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from holonom.errors import UnknownName
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.inverse.puma_geometry import puma_geometry
from holonom.mechanics.equations.singularities import parallel_measures, puma_measures, volume
from holonom.mechanics.equations.vectors import Vector, transpose
from holonom.mechanics.kernels.inverse.closed_form import closed_form
from holonom.mechanics.kernels.placement import Here, compile_here
from holonom.model import ArmModel
from holonom.trace import Kernel, Number

__all__ = ["NAMED", "PARTS", "SINGULARITIES", "measures_of", "rows_of"]

Options = Mapping[str, Any]
PARTS = {"all": slice(0, 6), "translation": slice(0, 3), "rotation": slice(3, 6)}
"""Rows of the Jacobian."""
NAMED = ("shoulder", "elbow", "wrist")


def rows_of(part: str) -> slice:
    """Rows of the Jacobian that make a part of it.

    Raises
    ------
    UnknownName
        No such part; lists them.
    """
    if part not in PARTS:
        raise UnknownName("part of the Jacobian", str(part), PARTS)
    return PARTS[part]


def _manipulability(model: ArmModel, options: Options) -> Kernel:
    n, part = len(model.independent), options["part"]
    wanted = rows_of(part)

    def equation(here: Here, q: Vector) -> list[Number]:
        J = kinematics.jacobian(here.model, q, "world")
        rows = [J[n * i : n * i + n] for i in range(6)][wanted]
        return [volume(rows if len(rows) <= n else transpose(rows))]

    return compile_here(model, options, equation, {"q": n}, {"w": ()}, name=f"manipulability_{part}")


def measures_of(model: ArmModel) -> Callable[[Vector], list[Number]] | None:
    """The equation of how near an arm is to each of its `NAMED` singularities, if it is built to have them."""
    puma = puma_geometry(model)
    if puma is not None:
        return lambda q: puma_measures(puma, q)
    form = closed_form(model)
    if form is not None and form.family == "three parallel axes":
        return lambda q: parallel_measures(model, q)
    return None


def _measures(model: ArmModel, options: Options) -> Kernel:
    equation = measures_of(model)
    if equation is None:
        raise UnknownName("kernel of arm", "singularity_measures", ())
    name, outputs = "singularity_measures", {"m": len(NAMED)}
    return compile_here(model, options, lambda here, q: equation(q), {"q": len(model.joints)}, outputs, name=name)


SINGULARITIES: Mapping[str, Callable[[ArmModel, Options], Kernel]] = {
    "manipulability": _manipulability,
    "singularity_measures": _measures,
}
