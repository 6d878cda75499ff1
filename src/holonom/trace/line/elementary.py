"""Sine, cosine and arctangent as equations, without a branch or a call: they become part of the line that needs them.

Coefficients: fdlibm (Sun Microsystems, 1993) for sine and cosine, Cephes (Moshier, 1989) for the arctangent. The
two-part Cody-Waite reduction is exact up to about 1.6e6 rad.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from holonom.trace.line.functions import absolute, copysign, floor, less, select
from holonom.trace.line.graph import Graph, Number, Scalar

__all__ = ["ELEMENTARY", "arctan2", "parameters", "sincos", "traced"]


def sincos(x: Number) -> tuple[Number, Number]:
    """Return sin x and cos x; error about 1e-16."""
    k = floor(x * 0.6366197723675814 + 0.5)
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
    half = k * 0.5
    odd = less(floor(half), half)  # in every other quarter sine and cosine change places
    turn = floor(half) * 0.5
    sign = 1.0 - 4.0 * (turn - floor(turn))
    s, c = s * sign, c * sign
    return select(odd, c, s), select(odd, -s, c)


def arctan2(y: Number, x: Number) -> Number:
    """Return the angle of (x, y) in (-pi, pi]; 0 at the origin; error about 3e-16."""
    ax, ay = absolute(x), absolute(y)
    steep = less(ax, ay)
    big, small = select(steep, ay, ax), select(steep, ax, ay)
    far = less(0.66 * big, small)
    below = select(far, small + big, big)
    u = select(far, small - big, small) / select(less(0.0, below), below, 1.0)
    z = u * u
    p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z
        - 7.500855792314704667340e1) * z - 1.228866684490136173410e2) * z - 6.485021904942025371773e1  # fmt: skip
    q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z
        + 4.328810604912902668951e2) * z + 4.853903996359136964868e2) * z + 1.945506571482613964425e2  # fmt: skip
    a = u + u * (z * p / q) + select(far, 0.7853981633974483, 0.0)
    a = select(steep, 1.5707963267948966 - a, a)
    a = select(less(x, 0.0), 3.141592653589793 - a, a)
    return copysign(a, y)


ELEMENTARY: dict[str, Callable[..., Number | tuple[Number, ...]]] = {"sincos": sincos, "arctan2": arctan2}
"""What a line calls by name."""


def parameters(name: str) -> Sequence[str]:
    """Names of the arguments of an elementary function."""
    code = ELEMENTARY[name].__code__
    return code.co_varnames[: code.co_argcount]


def traced(name: str) -> tuple[Graph, list[Scalar]]:
    """Graph and results of an elementary function."""
    graph = Graph()
    found = ELEMENTARY[name](*(graph.input(each, 0) for each in parameters(name)))
    return graph, [value for value in (found if isinstance(found, tuple) else (found,)) if isinstance(value, Scalar)]
