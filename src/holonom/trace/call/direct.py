"""Compiled functions that are called past Numba's dispatch, with arrays read where NumPy keeps them.

Numba looks up a signature, then makes a record of each array on the heap: 0.2 us and 0.1 us per array, as much as a
kernel. Here an argument is the Python object itself. `fits` is asked first, about each: whether it is an array of the
right type, shape and layout; then `array_of` reads it in place.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.cgutils import alloca_once, pack_array
from numba.extending import NativeValue, intrinsic, models, register_model, unbox
from numba.np.arrayobj import make_array, populate_array

from holonom.trace.call.layout import (
    ALIGNED,
    BYTE,
    BYTE_ORDER,
    C_CONTIGUOUS,
    DATA,
    FLAGS,
    INT,
    KIND,
    LONG,
    NDARRAY,
    NDIM,
    POINTER,
    SHAPE,
    TYPE,
    TYPE_NUMBER,
    WRITEABLE,
    load,
    symbol,
)

__all__ = ["ArrayObject", "array_of", "direct", "fits", "placed", "scratch"]

BOOL = ir.IntType(1)


class ArrayObject(types.Opaque):
    """Numba type of an argument that is to be an array of C layout; a length None: any."""

    def __init__(self, dtype: Any, shape: tuple[int | None, ...], written: bool = False) -> None:
        self.dtype, self.shape, self.written = dtype, shape, written
        super().__init__(f"{'written' if written else 'read'} {dtype} {shape}")


register_model(ArrayObject)(models.OpaqueModel)


@unbox(ArrayObject)
def _as_it_is(kind: Any, value: Any, context: Any) -> Any:
    return NativeValue(value)


def _fits(context: Any, given: Any) -> Any:
    """Whether an argument is the array that its `ArrayObject` says."""
    wanted = np.dtype(given.dtype.name)
    flags = C_CONTIGUOUS | ALIGNED | (WRITEABLE if given.written else 0)

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        value, ndarray = args[0], symbol(builder, NDARRAY)
        fine = builder.alloca(BOOL)
        builder.store(BOOL(0), fine)

        def all_equal(*pairs: tuple[Any, Any]) -> Any:
            result = BOOL(1)
            for a, b in pairs:
                result = builder.and_(result, builder.icmp_signed("==", a, b))
            return result

        kind = builder.ptrtoint(load(builder, value, TYPE, POINTER), LONG)
        with builder.if_then(all_equal((kind, builder.ptrtoint(ndarray, LONG)))):
            dtype, had = load(builder, value, KIND, POINTER), load(builder, value, FLAGS, INT)
            laid_out = all_equal(
                (load(builder, value, NDIM, INT), INT(len(given.shape))),
                (builder.and_(had, INT(flags)), INT(flags)),
                (load(builder, dtype, TYPE_NUMBER, INT), INT(wanted.num)),
                (load(builder, dtype, BYTE_ORDER, BYTE), BYTE(ord(wanted.byteorder))),
            )
            with builder.if_then(laid_out):
                shape = load(builder, value, SHAPE, POINTER)
                sizes = [(8 * k, size) for k, size in enumerate(given.shape) if size is not None]
                builder.store(all_equal(*((load(builder, shape, k, LONG), LONG(size)) for k, size in sizes)), fine)
        return builder.load(fine)

    return types.boolean(given), generate


def _array_of(context: Any, given: Any) -> Any:
    """The array behind an argument that fits; it lives as long as the call."""
    kind = types.Array(given.dtype, len(given.shape), "C")

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        start = load(builder, args[0], SHAPE, POINTER)
        known = enumerate(given.shape)
        shape = [load(builder, start, 8 * k, LONG) if size is None else LONG(size) for k, size in known]
        return placed(ctx, builder, kind, load(builder, args[0], DATA, POINTER), shape)

    return kind(given), generate


def _scratch(context: Any, count: Any) -> Any:
    """Room for numbers on the stack, until the calling function returns."""
    kind = types.Array(types.float64, 1, "C")

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = alloca_once(builder, ir.DoubleType(), size=count.literal_value)
        return placed(ctx, builder, kind, data, [LONG(count.literal_value)])

    return kind(count), generate


def placed(ctx: Any, builder: Any, kind: Any, data: Any, shape: Sequence[Any]) -> Any:
    """A C-contiguous array at a place in memory, which it does not own."""
    itemsize = step = LONG(kind.dtype.bitwidth // 8)
    strides: list[Any] = []
    for size in reversed(shape):
        strides.insert(0, step)
        step = builder.mul(step, size)
    made = make_array(kind)(ctx, builder)
    where = builder.bitcast(data, made.data.type)
    populate_array(
        made, where, pack_array(builder, shape, LONG), pack_array(builder, strides, LONG), itemsize, meminfo=None
    )
    return made._getvalue()


fits: Any = intrinsic(_fits)
"""`fits(argument)`: whether it is such an array."""
array_of: Any = intrinsic(_array_of)
"""`array_of(argument)`: the array, if it fits."""
scratch: Any = intrinsic(prefer_literal=True)(_scratch)
"""`scratch(count)`: an array of as many numbers, which are anything, until the function that asks returns."""


def direct(function: Any) -> Callable[..., Any]:
    """The one compiled version of a function whose arguments are `ArrayObject`s, to be called without dispatch."""
    (version,) = function.overloads.values()
    entry: Callable[..., Any] = version.entry_point
    return entry
