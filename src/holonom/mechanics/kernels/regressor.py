"""The compiled regressor."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

from holonom.mechanics.equations.dynamics.regressor import regressor
from holonom.model import ArmModel
from holonom.trace import Kernel, compile

__all__ = ["regressor_kernel"]


def regressor_kernel(model: ArmModel, options: Mapping[str, Any]) -> Kernel:
    """Y(q, qd, qdd); it takes no options, and no bodies."""
    n = len(model.independent)
    return compile(
        functools.partial(regressor, model),
        {"q": n, "qd": n, "qdd": n},
        {"Y": (n, 14 * len(model.joints))},
        name=f"{model.name}_regressor",
    )
