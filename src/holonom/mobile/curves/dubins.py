"""Dubins curves: the shortest way forwards between two poses for a base that turns no tighter than a radius.

Dubins, On curves of minimal length with a constraint on average curvature (Amer. J. Math. 79, 1957): one of six words.
Lengths after Shkel & Lumelsky, Classification of the Dubins set (Robotics and Autonomous Systems 34, 2001), eq. 11-16.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mobile.curves.curve import Curves, chosen, in_radii

__all__ = ["DUBINS_WORDS", "dubins"]

DUBINS_WORDS = ("LSL", "RSR", "LSR", "RSL", "RLR", "LRL")
"""Left, straight, right: what the three pieces of a curve do."""
ROUNDING = 1e-7
"""Length in radii, or angle, that is none: roots of differences know no better."""


def dubins(start: ArrayLike, end: ArrayLike, radius: float) -> Curves:
    """Return the shortest forward curve from each start pose (N, 3) to its end pose (N, 3), m and rad.

    Raises
    ------
    OutOfLimits
        A radius that is not above zero.
    ShapeError
    """
    first, goal = in_radii(start, end, radius)
    d, away = np.hypot(goal[:, 0], goal[:, 1]), np.arctan2(goal[:, 1], goal[:, 0])
    a, b = -away, goal[:, 2] - away
    with np.errstate(invalid="ignore"):
        lengths = np.stack([np.column_stack(word) for word in _words(d, a, b)])
    lengths[..., 1] = np.where(lengths[..., 1] < ROUNDING, 0.0, lengths[..., 1])
    lengths[..., [0, 2]] = np.where(lengths[..., [0, 2]] > 2.0 * np.pi - ROUNDING, 0.0, lengths[..., [0, 2]])
    return chosen(first, float(radius), DUBINS_WORDS, lengths)


def _words(d: Array, a: Array, b: Array) -> list[tuple[Array, Array, Array]]:
    """Lengths (t, p, q) of the six words from heading a to heading b over a distance d; NaN where there is none."""
    sa, sb, ca, cb, cab = np.sin(a), np.sin(b), np.cos(a), np.cos(b), np.cos(a - b)

    def root(square: Array) -> Array:
        return np.sqrt(np.where(square > -ROUNDING, np.maximum(square, 0.0), np.nan))

    left, right = sa - sb, sb - sa
    p_lsl, p_rsr = (root(2.0 + d * d - 2.0 * cab + 2.0 * d * side) for side in (left, right))
    lsl, rsr = np.arctan2(cb - ca, d + left), np.arctan2(ca - cb, d + right)
    lsl, rsr = np.where(p_lsl < ROUNDING, a, lsl), np.where(p_rsr < ROUNDING, a, rsr)  # one arc: all of it at its end
    p_lsr, p_rsl = (root(d * d - 2.0 + 2.0 * cab + 2.0 * d * side) for side in (sa + sb, -sa - sb))
    lsr = np.arctan2(-ca - cb, d + sa + sb) - np.arctan2(-2.0, p_lsr)
    rsl = np.arctan2(ca + cb, d - sa - sb) - np.arctan2(2.0, p_rsl)
    rlr, lrl = ((6.0 - d * d + 2.0 * cab + 2.0 * d * s * (sa - sb)) / 8.0 for s in (1.0, -1.0))
    p_rlr, p_lrl = (_turn(2.0 * np.pi - np.arccos(np.where(np.abs(c) <= 1.0, c, np.nan))) for c in (rlr, lrl))
    t_rlr = _turn(a - np.arctan2(ca - cb, d - sa + sb) + 0.5 * p_rlr)
    t_lrl = _turn(-a - np.arctan2(ca - cb, d + sa - sb) + 0.5 * p_lrl)
    return [
        (_turn(lsl - a), p_lsl, _turn(b - lsl)),
        (_turn(a - rsr), p_rsr, _turn(rsr - b)),
        (_turn(lsr - a), p_lsr, _turn(lsr - b)),
        (_turn(a - rsl), p_rsl, _turn(b - rsl)),
        (t_rlr, p_rlr, _turn(a - b - t_rlr + p_rlr)),
        (t_lrl, p_lrl, _turn(b - a - t_lrl + p_lrl)),
    ]


def _turn(angle: Array) -> Array:
    return np.mod(angle, 2.0 * np.pi)
