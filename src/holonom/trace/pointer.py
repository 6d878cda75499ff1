"""Calling a kernel by its C address from a compiled loop: the loop is compiled once, for every robot."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

__all__ = ["call_kernel"]


def _call_kernel(context: Any, address: Any, source: Any, target: Any) -> Any:
    """Call `void(double*, double*)` at `address` on the data of two arrays."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = ir.PointerType(ir.DoubleType())
        function = ir.FunctionType(ir.VoidType(), [pointer, pointer])
        data = [ctx.make_array(t)(ctx, builder, a).data for t, a in zip(signature.args[1:], args[1:], strict=True)]
        builder.call(builder.inttoptr(args[0], ir.PointerType(function)), data)
        return ctx.get_dummy_value()

    return types.void(types.int64, source, target), generate


call_kernel: Any = intrinsic(_call_kernel)
"""`call_kernel(address, inputs, outputs)`: address from `Kernel.address`, C-contiguous float64 arrays in a row."""
