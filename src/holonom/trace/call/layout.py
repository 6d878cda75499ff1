"""How Python and NumPy lay out objects in memory, for compiled code that reads and makes them.

The offsets are tried at load, on arrays and tuples whose answers Python and NumPy know themselves (`agrees`). Where one
differs, no object is taken for an array (see `NDARRAY`), and everything goes the general way.
"""

from __future__ import annotations

import ctypes
import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from llvmlite import binding, ir

__all__ = [
    "ALIGNED",
    "BYTE",
    "BYTE_ORDER",
    "C_CONTIGUOUS",
    "DATA",
    "FLAGS",
    "HEAD",
    "INT",
    "ITEMS",
    "KIND",
    "LONG",
    "NDARRAY",
    "NDIM",
    "NEW_ARRAY",
    "POINTER",
    "SHAPE",
    "SIZE",
    "STRIDES",
    "TYPE",
    "TYPE_NUMBER",
    "WRITEABLE",
    "agrees",
    "load",
    "place",
    "symbol",
]

BYTE, INT, LONG = ir.IntType(8), ir.IntType(32), ir.IntType(64)
POINTER = ir.PointerType(BYTE)

# PyObject and PyVarObject, PyTupleObject, then PyArrayObject_fields and PyArray_Descr of NumPy's C interface.
HEAD = object.__basicsize__
TYPE = HEAD - 8
SIZE, ITEMS = HEAD, tuple.__basicsize__
DATA, NDIM, SHAPE, STRIDES, KIND, FLAGS = HEAD, HEAD + 8, HEAD + 16, HEAD + 24, HEAD + 40, HEAD + 48
BYTE_ORDER, TYPE_NUMBER = HEAD + 10, HEAD + 12
C_CONTIGUOUS, ALIGNED, WRITEABLE = 0x1, 0x100, 0x400  # of the flags

# By name, so that machine code on disk finds them in every process.
NDARRAY = "holonom_ndarray"
"""The type of arrays; where their layout is not the known one, something that is the type of nothing."""
NEW_ARRAY = "holonom_new_array"
"""`PyArray_New` of NumPy's C interface, its 93rd entry."""


def load(builder: Any, start: Any, offset: int, kind: Any) -> Any:
    """What stands `offset` bytes after the start of an object."""
    return builder.load(place(builder, start, LONG(offset), kind), typ=kind)


def place(builder: Any, start: Any, offset: Any, kind: Any) -> Any:
    """The address `offset` bytes after the start of an object."""
    return builder.bitcast(builder.gep(start, [offset], source_etype=BYTE), kind.as_pointer())


def symbol(builder: Any, name: str) -> Any:
    """The address that has a name."""
    module = builder.module
    return module.globals.get(name) or ir.GlobalVariable(module, BYTE, name)


def agrees() -> bool:
    """Whether arrays and tuples lie in memory as the offsets above say: tried on some of which NumPy says it too."""
    whole = np.arange(24.0)
    arrays = [
        whole,  # first: its words are such that one of another meaning is no address
        whole.copy().reshape(2, 3, 4)[:, ::2, 1:],
        np.asfortranarray(whole.reshape(4, 6)),
        np.array(3.0),
        np.zeros((0, 5), np.int8),
        np.arange(6, dtype=np.int64)[::-2],
        whole.astype(">f8").reshape(8, 3),
        np.frombuffer(b"16 bytes of text"),
        np.frombuffer(bytearray(17), np.uint8)[1:].view(np.float64),
    ]
    tuples: list[tuple[Any, ...]] = [(whole,), (), (1.0, "b", whole), tuple(range(50))]
    return all(found == known for one in arrays for found, known in _answers(one)) and all(
        found == known for one in tuples for found, known in _answers_of_tuple(one)
    )


def _answers(array: Any) -> Iterator[tuple[Any, Any]]:
    """What compiled code reads of an array, and what NumPy says; in order, as each answer shows the way to the next."""
    start, offsets = id(array), (DATA, NDIM, SHAPE, STRIDES, KIND, FLAGS)
    yield all(HEAD <= offset < np.ndarray.__basicsize__ and offset % 8 == 0 for offset in offsets), True
    yield _read(start, TYPE, ctypes.c_size_t), id(type(array))
    yield _read(start, NDIM, ctypes.c_int), array.ndim
    yield (data := _read(start, DATA, ctypes.c_size_t)), array.ctypes.data
    known = array.flags
    named = C_CONTIGUOUS * known.c_contiguous | ALIGNED * known.aligned | WRITEABLE * known.writeable
    yield _read(start, FLAGS, ctypes.c_int) & (C_CONTIGUOUS | ALIGNED | WRITEABLE), named
    yield (kind := _read(start, KIND, ctypes.c_size_t)), id(array.dtype)
    yield max(TYPE_NUMBER, BYTE_ORDER) < np.dtype.__basicsize__, True
    yield _read(kind, TYPE_NUMBER, ctypes.c_int), array.dtype.num
    yield chr(_read(kind, BYTE_ORDER, ctypes.c_ubyte)), array.dtype.byteorder
    numbers = ctypes.c_ssize_t * array.ndim
    for offset, known in ((SHAPE, array.shape), (STRIDES, array.strides)):
        place = _read(start, offset, ctypes.c_size_t)
        yield array.ndim == 0 or (place > 4095 and place % 8 == 0), True
        yield tuple(numbers.from_address(place)) if array.ndim else (), known
    if array.size:
        last = data + sum(step * (size - 1) for step, size in zip(array.strides, array.shape, strict=True))
        yield ctypes.string_at(last, array.itemsize), array[(..., *[slice(-1, None)] * array.ndim)].tobytes()


def _answers_of_tuple(given: tuple[Any, ...]) -> Iterator[tuple[Any, Any]]:
    """What compiled code reads of a tuple, and what Python says."""
    yield ITEMS + 8 * len(given) <= tuple.__sizeof__(given) and HEAD <= SIZE < tuple.__basicsize__, True
    yield _read(id(given), TYPE, ctypes.c_size_t), id(type(given))
    yield _read(id(given), SIZE, ctypes.c_size_t), len(given)
    for k, held in enumerate(given):
        yield _read(id(given), ITEMS + 8 * k, ctypes.c_size_t), id(held)


def _read(start: int, offset: int, kind: Any) -> Any:
    return kind.from_address(start + offset).value


def _makes_arrays(address: int) -> bool:
    """Whether a function is `PyArray_New`."""
    number, pointer = ctypes.c_int, ctypes.c_void_p
    kind = ctypes.PYFUNCTYPE(
        ctypes.py_object, pointer, number, pointer, number, pointer, pointer, number, number, pointer
    )
    shape = (ctypes.c_ssize_t * 3)(2, 0, 5)
    made = kind(address)(id(np.ndarray), 3, ctypes.addressof(shape), np.dtype(np.int8).num, None, None, 0, 0, None)
    like = np.empty((2, 0, 5), np.int8)
    return type(made) is np.ndarray and (made.shape, made.dtype, made.strides) == (like.shape, like.dtype, like.strides)


def _new_array() -> int | None:
    """Address of `PyArray_New`; None if this NumPy is not the one whose layout stands above."""
    if np.__version__.split(".")[0] != "2":
        return None
    table = ctypes.pythonapi.PyCapsule_GetPointer
    table.restype, table.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    core: Any = importlib.import_module("numpy._core._multiarray_umath")
    entries = ctypes.cast(table(core._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p))
    fine = entries[2] == id(np.ndarray) and agrees() and _makes_arrays(entries[93] or 0)
    return entries[93] if fine else None


_ADDRESS = _new_array()
binding.add_symbol(NDARRAY, id(np.ndarray) if _ADDRESS else id(None))
binding.add_symbol(NEW_ARRAY, _ADDRESS or id(None))
