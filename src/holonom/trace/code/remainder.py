"""The rows of a batch that fill no vector: moved to arrays that do, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from holonom.trace.code.loops import loop

__all__ = ["back", "filled_up"]


@loop(nogil=True, error_model="numpy")
def filled_up(rows: Any, first: int, last: int, lanes: int) -> Any:
    """Return the rows (N, w) from `first` to `last`, with zeros below, (lanes, w)."""
    full = np.zeros((lanes, rows.shape[1]), rows.dtype)
    for row in range(first, last):
        for k in range(rows.shape[1]):
            full[row - first, k] = rows[row, k]
    return full


@loop(nogil=True, error_model="numpy")
def back(full: Any, rows: Any, first: int, last: int) -> None:
    """Write the rows from `first` to `last` of (N, w) as `full` has them at its start."""
    for row in range(first, last):
        for k in range(rows.shape[1]):
            rows[row, k] = full[row - first, k]
