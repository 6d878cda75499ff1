"""Motion of a base between samples of a run, in its own frame, turns weighed as the ways that make them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = ["moved"]


def moved(poses: Array, start: NDArray[np.intp], end: NDArray[np.intp], lever: float) -> Array:
    """Motion (K, 3) between samples `start` (K,) and `end` (K,) of `poses` (N, 3), headings without jumps.

    In the frame of the base half-way round; turns times `lever`, m.
    """
    step, turn = poses[end, :2] - poses[start, :2], poses[end, 2] - poses[start, 2]
    middle = poses[start, 2] + 0.5 * turn
    c, s = np.cos(middle), np.sin(middle)
    return np.stack([c * step[:, 0] + s * step[:, 1], -s * step[:, 0] + c * step[:, 1], lever * turn], axis=1)
