"""Elementary functions for compiled loops written by hand, without a branch, so that a loop around them vectorises.

`sincos` is the equation of `trace.elementary`. `select`, `arctan` and `sincos_half_turn` also take packs
(`trace.simd`). Coefficients of the last two are minimax polynomials (Remez).

Flags are named in such loops (`TRIG_FLAGS`): `fastmath=True` would delete NaN tests and spoil the reduction.
"""

from __future__ import annotations

import math
from typing import Any

from numba import types
from numba.extending import intrinsic

from holonom.trace.code.loops import loop
from holonom.trace.code.lower import lower
from holonom.trace.code.simd import Mask, pack

__all__ = ["TRIG_FLAGS", "arctan", "select", "sincos", "sincos_half_turn"]

TRIG_FLAGS = {"contract", "nsz"}


def _select(context: Any, condition: Any, a: Any, b: Any) -> Any:
    """`a if condition else b` as one instruction, of numbers or of packs: no branch to take apart again."""
    del context, a, b

    def generate(_: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.select(*args)

    if isinstance(condition, Mask):
        return pack(condition, pack, pack), generate
    if isinstance(condition, types.Boolean):
        return types.float64(types.boolean, types.float64, types.float64), generate
    return None


select: Any = intrinsic(_select)


@intrinsic
def _sincos(context: Any, x: Any) -> Any:
    del context
    return lower("s, c = sincos(x)\nreturn s, c", {"x": x}, sorted(TRIG_FLAGS))


def _both(x: float) -> tuple[float, float]:
    """Return sin x and cos x; error about 1e-16."""
    return _sincos(x)  # type: ignore[call-arg]


sincos: Any = loop(_both)


@loop(fastmath=TRIG_FLAGS, error_model="numpy")
def arctan(x: float) -> float:
    """Return the angle in [-pi/2, pi/2] whose tangent is x; error about 2e-16."""
    a = abs(x)
    steep, middle = a > 2.414213562373095, a > 0.41421356237309503  # tan 3 pi/8, tan pi/8
    u = select(steep, -1.0, select(middle, a - 1.0, a)) / select(steep, a, select(middle, a + 1.0, 1.0))
    z = u * u
    z2 = z * z
    low = _cubic(z, z2, -0.3333333333333022, 0.1999999999910397, -0.1428571419646369, 0.11111106700818447)
    high = _cubic(z, z2, -0.09090783462217188, 0.07690082391842872, -0.06641237705996288, 0.05693119391439536)
    end = 0.02127849872954017 * z - 0.04360692549858007
    start = select(steep, 1.5707963267948966, select(middle, 0.7853981633974483, 0.0))
    return math.copysign(start + (u + u * z * (low + z2 * z2 * (high + z2 * z2 * end))), x)


@loop(fastmath=TRIG_FLAGS, error_model="numpy")
def sincos_half_turn(x: float) -> tuple[float, float]:
    """Return sin x and cos x of an angle in [0, pi], relative error of the sine about 4e-16 below pi/2.

    Nothing is reduced: `sin x = x (pi - x) P(y^2)` and `cos x = y Q(y^2)` with `y = pi/2 - x`.
    """
    y = 1.5707963267948966 - x
    z = y * y
    z2 = z * z
    p = _cubic(z, z2, 0.4052847345693511, -0.03838665120972582, 0.0013293401938464962, -2.413417705343183e-05)
    p += (
        z2
        * z2
        * _cubic(z, z2, 2.7049116637421516e-07, -2.0596485585473445e-09, 1.134764914682732e-11, -4.589261871294986e-14)
    )
    q = _cubic(z, z2, -0.16666666666666666, 0.008333333333333212, -0.00019841269841215317, 2.7557319212137354e-06)
    q += (
        z2
        * z2
        * _cubic(z, z2, -2.5052106960692853e-08, 1.605894395646399e-10, -7.643098135194076e-13, 2.7222595812991942e-15)
    )
    return x * (3.141592653589793 - x) * p, y + y * z * q


@loop(fastmath=TRIG_FLAGS, error_model="numpy")
def _cubic(z: float, z2: float, a: float, b: float, c: float, d: float) -> float:
    """Return `a + b z + c z^2 + d z^3` in two steps instead of three (Estrin)."""
    return (a + b * z) + z2 * (c + d * z)
