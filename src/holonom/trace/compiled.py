"""Elementary functions for compiled loops written by hand: the same equations, so that a loop around them vectorises.

Flags are named in such loops (`TRIG_FLAGS`): `fastmath=True` would delete NaN tests and spoil the reduction.
"""

from __future__ import annotations

from typing import Any

from numba import njit, types
from numba.extending import intrinsic

from holonom.trace.lower import lower

__all__ = ["TRIG_FLAGS", "select", "sincos"]

TRIG_FLAGS = {"contract", "nsz"}


def _select(context: Any, condition: Any, a: Any, b: Any) -> Any:
    """`a if condition else b` as one instruction: no branch for the compiler to take apart again."""
    del context, condition, a, b

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.select(*args)

    return types.float64(types.boolean, types.float64, types.float64), generate


select: Any = intrinsic(_select)


@intrinsic
def _sincos(context: Any, x: Any) -> Any:
    del context
    return lower("s, c = sincos(x)\nreturn s, c", {"x": x}, sorted(TRIG_FLAGS))


def _both(x: float) -> tuple[float, float]:
    """Return sin x and cos x; error about 1e-16."""
    return _sincos(x)  # type: ignore[call-arg]


sincos: Any = njit(_both)
