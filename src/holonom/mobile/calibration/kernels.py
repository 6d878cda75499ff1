"""Compiled loops of the calibration."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.trace.code.loops import loop

__all__ = ["left_into"]


@loop(error_model="numpy")
def left_into(table: Array, basis: Array, shifts: NDArray[np.int64], every: int, out: Array) -> None:
    """Square sums `out` (R, ceil(K / every)) of motions that the columns of a basis (N, b) do not explain.

    They come from a table (K, N, 3) of motions at K offsets, row i at every `every`-th offset shifted by shifts (R, N).
    """
    offsets, n = table.shape[:2]
    told = np.empty((basis.shape[1], 3))
    for r in range(shifts.shape[0]):
        for k in range(0, offsets, every):
            told[:] = 0.0
            total = 0.0
            for i in range(n):
                at = min(max(k + shifts[r, i], 0), offsets - 1)
                for c in range(3):
                    value = table[at, i, c]
                    total += value * value
                    for b in range(basis.shape[1]):
                        told[b, c] += basis[i, b] * value
            out[r, k // every] = total - (told**2).sum()
