"""Sine, cosine and arctangent without a branch or a call, so that a loop around them vectorises.

Coefficients: fdlibm (Sun Microsystems, 1993) for sine and cosine, Cephes (Moshier, 1989) for the arctangent. The
two-part
Cody-Waite reduction is exact up to about 1.6e6 rad. Flags are named: `fastmath=True` would delete NaN tests and spoil
the reduction.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

__all__ = ["arctan2", "select", "sincos"]

TRIG_FLAGS = {"contract", "nsz"}


def _select(context: Any, condition: Any, a: Any, b: Any) -> Any:
    """`a if condition else b` as one instruction: no branch for the compiler to take apart again."""
    del context, condition, a, b

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.select(*args)

    return types.float64(types.boolean, types.float64, types.float64), generate


select: Any = intrinsic(_select)


@njit(fastmath=TRIG_FLAGS, error_model="numpy")
def sincos(x: float) -> tuple[float, float]:
    """Return sin x and cos x; error about 1e-16."""
    k = np.floor(x * 0.6366197723675814 + 0.5)
    r = (x - k * 1.5707963267341256) - k * 6.07710050650619e-11
    z = r * r
    s = r + r * z * (
        -1.6666666666666632e-1
        + z * (8.33333333332249e-3 + z * (-1.984126982985795e-4
        + z * (2.7557313707070068e-6 + z * (-2.5050760253406863e-8 + z * 1.58969099521155e-10))))
    )  # fmt: skip
    c = 1.0 - 0.5 * z + z * z * (
        4.16666666666666e-2
        + z * (-1.388888888887411e-3 + z * (2.480158728947673e-5
        + z * (-2.7557314351390663e-7 + z * (2.087572321298175e-9 - z * 1.1359647557788195e-11))))
    )  # fmt: skip
    h = k * 0.5
    odd = (h - np.floor(h)) * 2.0
    h2 = np.floor(h) * 0.5
    sign = 1.0 - 4.0 * (h2 - np.floor(h2))
    return (s + odd * (c - s)) * sign, (c + odd * (s - c)) * sign * (1.0 - 2.0 * odd)


@njit(fastmath=TRIG_FLAGS, error_model="numpy")
def arctan2(y: float, x: float) -> float:
    """Return the angle of (x, y) in (-pi, pi]; 0 at the origin; error about 3e-16."""
    ax, ay = abs(x), abs(y)
    big = select(ax > ay, ax, ay)
    small = select(ax > ay, ay, ax)
    far = small > 0.66 * big
    below = select(far, small + big, big)
    u = select(far, small - big, small) / select(below > 0.0, below, 1.0)
    z = u * u
    p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z
        - 7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1  # fmt: skip
    q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z
        + 4.328810604912902668951e2) * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2  # fmt: skip
    a = u + u * (z * p / q) + select(far, 0.7853981633974483, 0.0)
    a = select(ay > ax, 1.5707963267948966 - a, a)
    a = select(x < 0.0, 3.141592653589793 - a, a)
    return math.copysign(a, y)
