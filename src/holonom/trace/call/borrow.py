"""`borrowed`: arrays whose references a compiled loop does not count, since its caller holds them.

Each time that an array is taken out of a tuple Numba counts a reference up and down, atomically; a step of a controller
that has twenty arrays loses a third of its time with it.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["borrowed"]


def _borrowed(context: Any, value: Any) -> Any:
    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        return _without_owner(ctx, builder, signature.args[0], args[0])

    return value(value), generate


def _without_owner(ctx: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The same value, its arrays without an owner; tuples part by part."""
    if isinstance(kind, types.Array):
        array = ctx.make_array(kind)(ctx, builder, value)
        array.meminfo = ir.Constant(array.meminfo.type, None)
        array.parent = ir.Constant(array.parent.type, None)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        for k, part in enumerate(tuple(kind)):  # type: ignore[arg-type, var-annotated]
            inner = _without_owner(ctx, builder, part, builder.extract_value(value, k))
            value = builder.insert_value(value, inner, k)
    return value


borrowed: Any = intrinsic(_borrowed)
"""`borrowed(value)`: an array, or a tuple that holds arrays, to be used only as long as the caller holds it."""
