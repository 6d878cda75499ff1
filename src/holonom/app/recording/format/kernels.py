"""Compiled: poses as ROS writes them. A recorder does this for every frame of every tick."""

from __future__ import annotations

import math

import numpy as np

from holonom.arrays import Array
from holonom.trace.code.loops import loop

__all__ = ["fill_pose_rows"]


@loop(error_model="numpy")
def fill_pose_rows(poses: Array, out: Array) -> None:
    """Fill rows (k, 7), x y z and quaternion x y z w with w >= 0, of poses (k, 4, 4).

    The largest of the four is taken from the diagonal, the others from sums beside it (Shepperd, 1978).
    """
    q = np.empty(4)
    for n in range(len(poses)):
        T = poses[n]
        trace = T[0, 0] + T[1, 1] + T[2, 2]
        i = 3
        largest = trace
        for j in range(3):
            if T[j, j] > largest:
                i, largest = j, T[j, j]
        if i == 3:
            q[0], q[1], q[2], q[3] = T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1], 1.0 + trace
        else:
            j, k = (i + 1) % 3, (i + 2) % 3
            q[i] = 1.0 - trace + 2.0 * T[i, i]
            q[j], q[k], q[3] = T[j, i] + T[i, j], T[k, i] + T[i, k], T[k, j] - T[j, k]
        size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        if q[3] < 0.0:
            size = -size
        out[n, 0], out[n, 1], out[n, 2] = T[0, 3], T[1, 3], T[2, 3]
        for j in range(4):
            out[n, 3 + j] = q[j] / size
