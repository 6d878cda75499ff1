"""Whether one matrix is a rigid transform, in compiled code: what a verb asks before a kernel of two microseconds."""

from __future__ import annotations

import numpy as np
from numba import boolean, float64
from numpy.typing import NDArray

from holonom.spatial.poses import RIGID
from holonom.trace.code.loops import loop

__all__ = ["is_rigid"]


@loop(boolean(float64[:, ::1]), error_model="numpy")
def is_rigid(T: NDArray[np.float64]) -> bool:
    """Whether T (4, 4) passes `spatial.check_pose`; False for NaN."""
    if T.shape[0] != 4 or T.shape[1] != 4:
        return False
    for i in range(3):
        for j in range(i + 1):
            dot = T[i, 0] * T[j, 0] + T[i, 1] * T[j, 1] + T[i, 2] * T[j, 2]
            if not abs(dot - (1.0 if i == j else 0.0)) <= RIGID:
                return False
        if not abs(T[i, 3]) < np.inf:
            return False
    determinant = (
        T[0, 0] * (T[1, 1] * T[2, 2] - T[1, 2] * T[2, 1])
        - T[0, 1] * (T[1, 0] * T[2, 2] - T[1, 2] * T[2, 0])
        + T[0, 2] * (T[1, 0] * T[2, 1] - T[1, 1] * T[2, 0])
    )
    return determinant > 0.0 and T[3, 0] == 0.0 and T[3, 1] == 0.0 and T[3, 2] == 0.0 and T[3, 3] == 1.0
