"""Records for compiled loops: layouts from parameter tuples, whole cache lines, four records side by side."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, get_type_hints

import numpy as np
from numpy.typing import NDArray

from holonom.trace.code.simd import WIDTH

__all__ = ["aligned_records", "layout_of", "padded", "record_table", "side_by_side"]

CACHE_LINE = 64
NUMBERS: Mapping[type, type[np.generic]] = {float: np.float64, int: np.int64, bool: np.bool_}


def layout_of(params: type) -> np.dtype[np.void]:
    """Return a NamedTuple of numbers, and of such tuples, as a NumPy record, which compiled steps take in its place."""
    kinds = get_type_hints(params)
    fields = [(name, NUMBERS[kind] if kind in NUMBERS else layout_of(kind)) for name, kind in kinds.items()]
    return np.dtype(fields, align=True)


def record_table(rows: list[Any], dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Return rows, NamedTuples that may hold others, as records (n,)."""
    return np.array([_plain(row) for row in rows], dtype=dtype)


def _plain(row: Any) -> Any:
    return tuple(_plain(part) if isinstance(part, tuple) else part for part in row)


def padded(fields: list[tuple[str, Any]]) -> np.dtype[np.void]:
    """Record of whole cache lines: a compiled step takes a quarter longer where fields lie across them."""
    plain = np.dtype(fields)
    spare = -plain.itemsize % CACHE_LINE // 8
    return np.dtype([*fields, ("spare", np.float64, (spare,))]) if spare else plain


def aligned_records(rows: Any, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Copy rows, as `np.array` takes them or fewer fields, into records that begin at a cache line."""
    buffer = np.zeros(len(rows) * dtype.itemsize + CACHE_LINE, np.uint8)
    first = -buffer.ctypes.data % CACHE_LINE
    records: NDArray[np.void] = buffer[first : first + len(rows) * dtype.itemsize].view(dtype)
    for record, row in zip(records, rows, strict=True):
        for name, value in zip(dtype.names or (), row, strict=False):
            record[name] = value
    return records


def side_by_side(rows: NDArray[np.void], **filling: float) -> NDArray[np.void]:
    """Lay records side by side, four in one, for `trace.simd.packed`.

    The last row is repeated until the four are full, with other values of the fields in `filling`.
    """
    count = -(-len(rows) // WIDTH)
    blocks = aligned_records([()] * count, _in_lanes(rows.dtype))
    _lay(blocks, rows[np.minimum(np.arange(count * WIDTH), len(rows) - 1)].reshape(count, WIDTH))
    for name, value in filling.items():
        blocks[name].flat[len(rows) :] = value
    return blocks


@functools.cache
def _in_lanes(dtype: np.dtype[np.void]) -> np.dtype[np.void]:
    """A record of four records: each number is an array (4,).

    One object each: Numba knows a layout by the object, and looks longer at another one at every call.
    """
    return np.dtype(
        [(name, _in_lanes(dtype[name]) if dtype[name].names else (dtype[name], (WIDTH,))) for name in dtype.names or ()]
    )


def _lay(blocks: NDArray[np.void], rows: NDArray[np.void]) -> None:
    for name in rows.dtype.names or ():
        if rows.dtype[name].names:
            _lay(blocks[name], rows[name])
        else:
            blocks[name] = rows[name]
