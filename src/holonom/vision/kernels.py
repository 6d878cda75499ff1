"""Compiled loops of the vision layer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from holonom.trace.code.loops import loop

__all__ = ["closed_path"]


@loop
def closed_path(
    score: NDArray[np.float32],
    price: NDArray[np.float32],
    best: NDArray[np.float32],
    came: NDArray[np.int16],
    path: NDArray[np.int64],
) -> None:
    """Column of each row of `score` (n, m) along the best closed path down the rows.

    The path gains `score` and pays `price[|move|]` for moving columns between rows. The rows are walked
    twice; of the two turns the middle one is kept, which closes on itself. `best` (2, m) and `came`
    (2 n, m) are work space, `path` (n,) is the result.
    """
    rows, columns = score.shape
    reach = price.size - 1
    best[0] = score[0]
    for row in range(1, 2 * rows):
        old, new = best[(row - 1) % 2], best[row % 2]
        for column in range(columns):
            top, top_at = np.float32(-np.inf), column
            for at in range(max(0, column - reach), min(columns, column + reach + 1)):
                value = old[at] - price[abs(at - column)]
                if value > top:
                    top, top_at = value, at
            new[column] = top + score[row % rows, column]
            came[row, column] = top_at
    at = int(np.argmax(best[(2 * rows - 1) % 2]))
    for row in range(2 * rows - 1, rows // 2 - 1, -1):
        if row < rows // 2 + rows:
            path[row % rows] = at
        at = came[row, at]
