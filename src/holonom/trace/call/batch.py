"""The arrays of a batch, given as Python objects: checked, and evaluated where they lie, in one compiled call.

NumPy's attributes take 50 ns each, a batch of three inputs needs twenty; here they are read from NumPy's C structures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from holonom.trace.call.crew import board, run
from holonom.trace.call.direct import direct
from holonom.trace.call.layout import (
    ALIGNED,
    BYTE,
    BYTE_ORDER,
    C_CONTIGUOUS,
    DATA,
    FLAGS,
    INT,
    ITEMS,
    KIND,
    LONG,
    NDARRAY,
    NDIM,
    SHAPE,
    SIZE,
    STRIDES,
    TYPE,
    TYPE_NUMBER,
    WRITEABLE,
    symbol,
)
from holonom.trace.code.loops import loop

__all__ = ["Batch"]

READ = C_CONTIGUOUS | ALIGNED


def _reader(kind: Any) -> Any:
    def read(context: Any, address: Any, offset: Any) -> Any:
        def generate(ctx: Any, builder: Any, signature: Any, args: Any) -> Any:
            place = builder.inttoptr(builder.add(*args), ir.PointerType(kind))
            value = builder.load(place, typ=kind)
            return value if kind == LONG else builder.sext(value, LONG)

        return types.int64(types.int64, types.int64), generate

    return intrinsic(read)


_long, _int, _byte = _reader(LONG), _reader(INT), _reader(BYTE)


def _type_of_arrays(context: Any) -> Any:
    """Its address."""
    return types.int64(), lambda ctx, builder, signature, args: builder.ptrtoint(symbol(builder, NDARRAY), LONG)


_ndarray: Any = intrinsic(_type_of_arrays)


@loop(nogil=True, error_model="numpy")
def _fits(array: int, like: int, count: int, flags: int) -> bool:
    """Whether an object is an array with so many rows, each like one of another array."""
    if _long(array, TYPE) != _ndarray() or _int(array, NDIM) != _int(like, NDIM) or _int(array, FLAGS) & flags != flags:
        return False
    kind, wanted = _long(array, KIND), _long(like, KIND)
    if _int(kind, TYPE_NUMBER) != _int(wanted, TYPE_NUMBER) or _byte(kind, BYTE_ORDER) != _byte(wanted, BYTE_ORDER):
        return False
    shape, row = _long(array, SHAPE), _long(like, SHAPE)
    for k in range(1, _int(like, NDIM)):
        if _long(shape, 8 * k) != _long(row, 8 * k):
            return False
    return _long(shape, 0) == count


@loop(nogil=True, error_model="numpy")
def _bytes(like: int) -> int:
    """Bytes of an array (1, ...): NumPy's stride over its first axis is all of it."""
    return _long(_long(like, STRIDES), 0)


@loop(types.boolean(*[types.int64] * 4), nogil=True, error_model="numpy")
def _evaluate(form: int, given: int, threads: int, board: int) -> bool:
    """Evaluate a batch form on arrays of any number of rows (N, ...); False if something else is given, or NaN in it.

    Parameters
    ----------
    form
        Address of what `Batch.form` holds: `likes` are the `id` of a tuple of arrays (1, ...), which say what is needed
        of type and rows; the first `inputs` of them are read, and the others written.
    given
        `id` of a tuple of the arrays. What is written must not overlap what is read.
    threads, board
        How many threads there may be, and the board of their crew.
    """
    address, likes, inputs, least = _long(form, 0), _long(form, 8), _long(form, 16), _long(form, 24)
    total = _long(likes, SIZE)
    first = _long(given, ITEMS)
    if _long(given, SIZE) != total or _long(first, TYPE) != _ndarray() or _int(first, NDIM) < 1:
        return False
    count = _long(_long(first, SHAPE), 0)
    places, ends = np.empty(total, np.int64), np.empty(total, np.int64)
    for k in range(total):
        array, like = _long(given, ITEMS + 8 * k), _long(likes, ITEMS + 8 * k)
        if not _fits(array, like, count, READ if k < inputs else READ | WRITEABLE):
            return False
        places[k] = _long(array, DATA)
        ends[k] = places[k] + count * _bytes(like)
    for k in range(inputs):
        for j in range(inputs, total):
            if places[k] < ends[j] and places[j] < ends[k]:
                return False
    if count == 0:
        return True
    parts = min(threads, count // least)
    return run(address, places.ctypes.data, count, parts, board)


_quick = direct(_evaluate)


class Batch:
    """The batch form at an address, with what it takes: so many inputs, then outputs, each row like these (1, ...)."""

    def __init__(self, address: int, inputs: int, likes: tuple[Any, ...], least: int) -> None:
        """`least`: rows that are worth a thread."""
        self._likes = likes
        self.form = np.array([address, id(likes), inputs, least])
        self._place = self.form.ctypes.data

    def __deepcopy__(self, memo: Any) -> Batch:
        """Itself: nothing in it changes, and addresses are of what is here."""
        return self

    def quick(self, given: tuple[Any, ...], threads: int) -> bool:
        """Evaluate arrays of rows; False if any of them is something else, or if there is NaN or infinity in them."""
        fine: bool = _quick(self._place, id(given), threads, board(threads) if threads > 1 else 0)
        return fine

    def run(self, given: Sequence[Any], count: int, threads: int) -> bool:
        """Evaluate arrays that are known to be C-contiguous, with so many rows; whether all inputs were finite."""
        places = np.array([array.ctypes.data for array in given])
        parts = min(threads, count // int(self.form[3]))
        fine: bool = run(int(self.form[0]), places.ctypes.data, count, parts, board(threads) if threads > 1 else 0)
        return fine
