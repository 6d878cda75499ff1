"""Whole numbers in memory that several threads read and change, by their address; each step is seen by all in order.

Also what threads wait with: `pause` between two looks, Python's locks without Python.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

from llvmlite import binding, ir
from numba import types
from numba.core.cgutils import get_or_insert_function
from numba.extending import intrinsic

__all__ = ["acquire", "add", "exchange", "exchange_if", "load", "new_lock", "pause", "release", "store"]

BYTE, INT, LONG = ir.IntType(8), ir.IntType(32), ir.IntType(64)
POINTER = ir.PointerType(BYTE)
ORDER = "seq_cst"


def _step(result: Any, values: int, emit: Callable[..., Any]) -> Any:
    """An intrinsic of an address and so many int64, that `emit(builder, pointer, *values)` writes."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        made = emit(builder, builder.inttoptr(args[0], ir.PointerType(LONG)), *args[1:])
        return ctx.get_dummy_value() if result == types.void else made

    kind = result(types.int64, *[types.int64] * values)
    by_count: dict[int, Callable[..., Any]] = {
        0: lambda context, address: (kind, generate),
        1: lambda context, address, value: (kind, generate),
        2: lambda context, address, expected, value: (kind, generate),
    }
    return intrinsic(by_count[values])


def _exchange_if(builder: Any, place: Any, expected: Any, value: Any) -> Any:
    return builder.extract_value(builder.cmpxchg(place, expected, value, ORDER, ORDER), 1)


load: Any = _step(types.int64, 0, lambda builder, place: builder.load_atomic(place, ORDER, 8, typ=LONG))
"""`load(address)`: the number there."""
store: Any = _step(types.void, 1, lambda builder, place, value: builder.store_atomic(value, place, ORDER, 8))
"""`store(address, value)`."""
add: Any = _step(types.int64, 1, lambda builder, place, value: builder.atomic_rmw("add", place, value, ORDER))
"""`add(address, value)`: the number that was there before."""
exchange: Any = _step(types.int64, 1, lambda builder, place, value: builder.atomic_rmw("xchg", place, value, ORDER))
"""`exchange(address, value)`: the number that was there before."""
exchange_if: Any = _step(types.boolean, 2, _exchange_if)
"""`exchange_if(address, expected, value)`: whether the expected number was there, and the value is now."""


def _pause(context: Any) -> Any:
    """Tell the processor that a loop only waits, where it has an instruction for that."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        machine = binding.get_process_triple().split("-")[0]
        if machine in ("x86_64", "i386", "i686"):
            builder.call(
                get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), "llvm.x86.sse2.pause"), []
            )
        elif machine in ("aarch64", "arm64"):
            hint = ir.FunctionType(ir.VoidType(), [INT])
            builder.call(get_or_insert_function(builder.module, hint, "llvm.aarch64.hint"), [INT(1)])
        return ctx.get_dummy_value()

    return types.void(), generate


def new_lock() -> int:
    """Return one of Python's locks, held: it stays for as long as the process."""
    make = ctypes.pythonapi.PyThread_allocate_lock
    make.restype, make.argtypes = ctypes.c_void_p, []
    take = ctypes.pythonapi.PyThread_acquire_lock
    take.restype, take.argtypes = ctypes.c_int, [ctypes.c_void_p, ctypes.c_int]
    lock: int | None = make()
    if lock is None or take(lock, 0) != 1:
        raise MemoryError("no memory for a lock")
    return lock


def _acquire(context: Any, lock: Any) -> Any:
    """Wait for a lock, asleep."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = ir.FunctionType(INT, [POINTER, INT])
        function = get_or_insert_function(builder.module, kind, "PyThread_acquire_lock")
        builder.call(function, [builder.inttoptr(args[0], POINTER), INT(1)])
        return ctx.get_dummy_value()

    return types.void(types.int64), generate


def _release(context: Any, lock: Any) -> Any:
    """Let go of a lock, from any thread."""

    def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
        function = get_or_insert_function(
            builder.module, ir.FunctionType(ir.VoidType(), [POINTER]), "PyThread_release_lock"
        )
        builder.call(function, [builder.inttoptr(args[0], POINTER)])
        return ctx.get_dummy_value()

    return types.void(types.int64), generate


pause: Any = intrinsic(_pause)
"""`pause()`."""
acquire: Any = intrinsic(_acquire)
"""`acquire(lock)`, of `new_lock`: to be called without the interpreter lock."""
release: Any = intrinsic(_release)
"""`release(lock)`."""
