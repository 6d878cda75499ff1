"""Compiled passes of `speed_profile`: what a base can do at a place and a speed; backwards and forwards over the path.

At place i, with the squared speed z along the path and the acceleration a along it, everything asked for is linear:
rim force `force[i, j] . (a, z)`, load `load[i, k] . (1, a, z)`, force across `across[i] . (a, z)`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.trace.code.loops import loop

__all__ = ["Demands", "acceleration_range", "slack", "speed_pass"]

HALVINGS = 45
GOLDEN = 0.6180339887498949


class Demands(NamedTuple):
    """What a base is asked for along a path, and what it has; m driven wheels of w, n places.

    `rim` (n, m) rim speed per speed; `force` (n, m, 2) N; `load` (n, w, 3) N; `across` (n, 2) N; `cap` (n,) largest z;
    `driven` (m,) which wheels; `holds` (w,) whether a wheel holds the base across; `cosine` (m,) of the roller angles;
    friction; motor forces `low`, `high` (q,) N at rim speeds from `-top` to `top` (m/s); `most` (m/s^2) bounds all a.
    """

    rim: Array
    force: Array
    load: Array
    across: Array
    cap: Array
    driven: NDArray[np.int64]
    holds: NDArray[np.bool_]
    cosine: Array
    friction: float
    top: float
    low: Array
    high: Array
    most: float


@loop(error_model="numpy")
def slack(d: Demands, i: int, z: float, a: float) -> float:
    """Force (N) that is left of the scarcest: of motors, floor, wheel loads; below 0: it cannot be done."""
    left, v = math.inf, math.sqrt(z)
    carried, w = 0.0, d.load.shape[1]
    for k in range(w):
        n = d.load[i, k, 0] + d.load[i, k, 1] * a + d.load[i, k, 2] * z
        left = min(left, n)
        if d.holds[k]:
            carried += n
    grip = d.friction
    if grip < math.inf:
        across = abs(d.across[i, 0] * a + d.across[i, 1] * z)
        held = across / max(carried, 1e-9)  # every wheel that holds does so in proportion to its load
        if across > 0.0 and held > grip:
            return min(left, carried * grip - across)
        grip = math.sqrt(grip * grip - held * held) if across > 0.0 else grip
    last = d.low.shape[0] - 1
    for j in range(d.rim.shape[1]):
        f = d.force[i, j, 0] * a + d.force[i, j, 1] * z
        at = min(max((v * d.rim[i, j] + d.top) * last / (2.0 * d.top), 0.0), float(last))
        q = min(int(at), last - 1)
        part = at - q
        left = min(left, d.high[q] + part * (d.high[q + 1] - d.high[q]) - f)
        left = min(left, f - d.low[q] - part * (d.low[q + 1] - d.low[q]))
        if grip < math.inf:
            k = d.driven[j]
            n = d.load[i, k, 0] + d.load[i, k, 1] * a + d.load[i, k, 2] * z
            left = min(left, grip * d.cosine[j] * n - abs(f))
    return left


@loop(error_model="numpy")
def acceleration_range(d: Demands, i: int, z: float) -> tuple[float, float, bool]:
    """Least and greatest acceleration (m/s^2) at a place and a squared speed, and whether there is any."""
    low, high = -d.most, d.most
    a = 0.0
    best = slack(d, i, z, a)
    if best < 0.0:  # look for the acceleration that leaves most: slack has one peak
        p, q = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        sp, sq = slack(d, i, z, p), slack(d, i, z, q)
        for _ in range(HALVINGS):
            if sp > sq:
                high, q, sq = q, p, sp
                p = high - GOLDEN * (high - low)
                sp = slack(d, i, z, p)
            else:
                low, p, sp = p, q, sq
                q = low + GOLDEN * (high - low)
                sq = slack(d, i, z, q)
            if max(sp, sq) >= 0.0:
                break
        a = p if sp > sq else q
        if max(sp, sq) < 0.0:
            return a, a, False
    return _edge(d, i, z, a, -d.most), _edge(d, i, z, a, d.most), True


@loop(error_model="numpy")
def _edge(d: Demands, i: int, z: float, inside: float, outside: float) -> float:
    if slack(d, i, z, outside) >= 0.0:
        return outside
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        if slack(d, i, z, middle) >= 0.0:
            inside = middle
        else:
            outside = middle
    return inside


@loop(error_model="numpy")
def speed_pass(d: Demands, step: Array, square: Array) -> int:
    """Fill squared speeds (n,) at places that lie steps (n - 1,), m, apart; return where it is stuck, or -1.

    First the largest at which any acceleration is allowed, then backwards with the least acceleration of each place
    (what can still be braked), then forwards with the greatest. Each step takes the mean of its two ends.
    """
    n = square.shape[0]
    for i in range(n):
        low, high = 0.0, d.cap[i]
        if not acceleration_range(d, i, low)[2]:
            return i
        if not acceleration_range(d, i, high)[2]:
            for _ in range(HALVINGS):
                middle = 0.5 * (low + high)
                if acceleration_range(d, i, middle)[2]:
                    low = middle
                else:
                    high = middle
            square[i] = low
        else:
            square[i] = high
    for back in range(n - 1):
        i = n - 2 - back
        here = square[i + 1]
        first = acceleration_range(d, i + 1, here)[0]
        there = min(max(here - 2.0 * step[i] * first, 0.0), square[i])
        second = acceleration_range(d, i, there)[0]
        square[i] = min(max(here - step[i] * (first + second), 0.0), square[i])
    for i in range(n - 1):
        here = square[i]
        first = acceleration_range(d, i, here)[1]
        there = min(max(here + 2.0 * step[i] * first, 0.0), square[i + 1])
        second = acceleration_range(d, i + 1, there)[1]
        square[i + 1] = min(max(here + step[i] * (first + second), 0.0), square[i + 1])
        if square[i + 1] <= 0.0 and step[i] > 0.0 and d.cap[i + 1] > 0.0:
            return i + 1
    return -1
