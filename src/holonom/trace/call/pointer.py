"""Calling a kernel by its C address from a compiled loop: the loop is compiled once, for every robot."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from holonom.trace.call.direct import placed

__all__ = ["call_kernel", "call_rows", "call_step", "table_at"]

LONG = ir.IntType(64)


def _call_kernel(context: Any, address: Any, source: Any, target: Any) -> Any:
    """Call `void(double*, double*)` at `address` on the data of two arrays."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = ir.PointerType(ir.DoubleType())
        function = ir.FunctionType(ir.VoidType(), [pointer, pointer])
        data = [ctx.make_array(t)(ctx, builder, a).data for t, a in zip(signature.args[1:], args[1:], strict=True)]
        builder.call(builder.inttoptr(args[0], ir.PointerType(function)), data)
        return ctx.get_dummy_value()

    return types.void(types.int64, source, target), generate


def _call_rows(context: Any, address: Any, places: Any, first: Any, last: Any) -> Any:
    """Call `double(int64*, int64, int64)` at `address` on the data of an array."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        function = ir.FunctionType(ir.DoubleType(), [ir.PointerType(LONG), LONG, LONG])
        start = builder.inttoptr(args[1], ir.PointerType(LONG))
        return builder.call(builder.inttoptr(args[0], ir.PointerType(function)), [start, *args[2:]])

    return types.float64(types.int64, types.int64, types.int64, types.int64), generate


def _call_step(context: Any, address: Any, settings: Any, rows: Any, numbers: Any) -> Any:
    """Call `void(void*, double*, int64, double*)` at `address` on the data of three arrays; the second's length."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        byte, double = ir.PointerType(ir.IntType(8)), ir.PointerType(ir.DoubleType())
        function = ir.FunctionType(ir.VoidType(), [byte, double, LONG, double])
        given, path, io = (
            ctx.make_array(t)(ctx, builder, a) for t, a in zip(signature.args[1:], args[1:], strict=True)
        )
        count = builder.extract_value(path.shape, 0)
        data = [builder.bitcast(given.data, byte), path.data, count, io.data]
        builder.call(builder.inttoptr(args[0], ir.PointerType(function)), data)
        return ctx.get_dummy_value()

    return types.void(types.int64, settings, rows, numbers), generate


def _table_at(context: Any, address: Any, rows: Any, width: Any, dtype: Any) -> Any:
    kind = types.Array(dtype.dtype, 2, "C")

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = builder.inttoptr(args[0], ir.PointerType(ir.IntType(8)))
        return placed(ctx, builder, kind, data, [args[1], args[2]])

    return kind(types.int64, types.int64, types.int64, dtype), generate


call_kernel: Any = intrinsic(_call_kernel)
"""`call_kernel(address, inputs, outputs)`: address from `Kernel.address`, C-contiguous float64 arrays in a row."""
call_rows: Any = intrinsic(_call_rows)
"""`call_rows(address, places, first, last)`: address from `Kernel.rows`; at `places`, the arrays' addresses."""
call_step: Any = intrinsic(_call_step)
"""`call_step(address, settings, rows, numbers)`: a step compiled by `callback`; settings are bytes."""
table_at: Any = intrinsic(_table_at)
"""`table_at(address, rows, width, dtype)`: the array (rows, width) that lies there, C-contiguous and not owned."""
