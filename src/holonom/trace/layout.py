"""How Python and NumPy lay out objects in memory, for compiled code that reads and makes them.

Where NumPy is another one than this was written for, no object is taken for an array: see `NDARRAY`.
"""

from __future__ import annotations

import ctypes
import importlib
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


def _new_array() -> int | None:
    """Address of `PyArray_New`; None if this NumPy is not the one whose layout stands above."""
    if np.__version__.split(".")[0] != "2":
        return None
    table = ctypes.pythonapi.PyCapsule_GetPointer
    table.restype, table.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    core: Any = importlib.import_module("numpy._core._multiarray_umath")
    entries = ctypes.cast(table(core._ARRAY_API, None), ctypes.POINTER(ctypes.c_void_p))
    return entries[93] if entries[2] == id(np.ndarray) else None


_ADDRESS = _new_array()
binding.add_symbol(NDARRAY, id(np.ndarray) if _ADDRESS else id(None))
binding.add_symbol(NEW_ARRAY, _ADDRESS or id(None))
