"""The compiled regressor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from holonom.mechanics.equations.dynamics.regressor import regressor
from holonom.mechanics.kernels.placement import compile_here
from holonom.model import ArmModel
from holonom.trace import Kernel

__all__ = ["regressor_kernel"]


def regressor_kernel(model: ArmModel, options: Mapping[str, Any]) -> Kernel:
    """Y(q, qd, qdd); it takes no options, and no bodies."""
    n = len(model.independent)
    return compile_here(
        model,
        options,
        lambda here, q, qd, qdd: regressor(here.model, q, qd, qdd),
        {"q": n, "qd": n, "qdd": n},
        {"Y": (n, 14 * len(model.joints))},
        name="regressor",
    )
