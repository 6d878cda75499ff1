"""Reeds-Shepp curves: the shortest way between two poses for a car that drives forwards and backwards.

Reeds & Shepp, Optimal paths for a car that goes both forwards and backwards (Pacific J. Math. 145, 1990): one of 48
words. Each formula 8.1 to 8.11 gives a word from the origin to (x, y, phi); time flip (x, -phi to the other side),
reflection and the way back give the others.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.mobile.curves.curve import Curves, chosen, in_radii

__all__ = ["REEDS_SHEPP_WORDS", "reeds_shepp"]

QUARTER = 0.5 * np.pi
ROUNDING = 1e-10
"""By which a length may have the wrong sign and count as none."""
Lengths = tuple[Array | float, ...]
Formula = Callable[[Array, Array, Array], tuple[Lengths, Array]]


def reeds_shepp(start: ArrayLike, end: ArrayLike, radius: float) -> Curves:
    """Return the shortest curve, reversing where that helps, from each start pose (N, 3) to its end pose (N, 3).

    Raises
    ------
    OutOfLimits
        A radius that is not above zero.
    ShapeError
    """
    first, goal = in_radii(start, end, radius)
    x, y, phi = goal.T
    c, s = np.cos(phi), np.sin(phi)
    found: list[Array] = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for _, formula, backwards in _FAMILIES:
            u, v = (x * c + y * s, x * s - y * c) if backwards else (x, y)
            for flip in (1.0, -1.0):
                for side in (1.0, -1.0):
                    lengths, holds = formula(flip * u, side * v, flip * side * phi)
                    ordered = lengths[::-1] if backwards else lengths
                    row = np.zeros((len(x), 5))
                    for k, length in enumerate(ordered):
                        row[:, k] = flip * np.asarray(length)
                    row[np.logical_not(holds)] = np.nan
                    found.append(row)
    return chosen(first, float(radius), REEDS_SHEPP_WORDS, np.stack(found))


def _angle(value: Array) -> Array:
    """The angle in (-pi, pi]; one that is -pi but for rounding is pi."""
    turned = np.pi - np.mod(np.pi - value, 2.0 * np.pi)
    return np.where(turned < -np.pi + ROUNDING, np.pi, turned)


def _polar(x: Array, y: Array) -> tuple[Array, Array]:
    return np.hypot(x, y), np.arctan2(y, x)


def _positive(*values: Array) -> Array:
    return np.all([value >= -ROUNDING for value in values], axis=0)


def _lsl(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.1: L+ S+ L+."""
    u, t = _polar(x - np.sin(phi), y - 1.0 + np.cos(phi))
    v = _angle(phi - t)
    return (t, u, v), _positive(t, v)


def _lsr(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.2: L+ S+ R+."""
    u1, t1 = _polar(x + np.sin(phi), y - 1.0 - np.cos(phi))
    u = np.sqrt(np.where(u1 >= 2.0, u1 * u1 - 4.0, np.nan))
    t = _angle(t1 + np.arctan2(2.0, u))
    v = _angle(t - phi)
    return (t, u, v), _positive(t, v, u)


def _lrl(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.3 and 8.4: L+ R- L."""
    u1, theta = _polar(x - np.sin(phi), y - 1.0 + np.cos(phi))
    u = -2.0 * np.arcsin(np.where(u1 <= 4.0, 0.25 * u1, np.nan))
    t = _angle(theta + 0.5 * u + np.pi)
    v = _angle(phi - t + u)
    return (t, u, v), _positive(t, -u)


def _tau_omega(u: Array, v: Array, xi: Array, eta: Array, phi: Array) -> tuple[Array, Array]:
    """tau and omega of 8.7 and 8.8."""
    delta = _angle(u - v)
    a, b = np.sin(u) - np.sin(delta), np.cos(u) - np.cos(delta) - 1.0
    t1 = np.arctan2(eta * a - xi * b, xi * a + eta * b)
    t2 = 2.0 * (np.cos(delta) - np.cos(v) - np.cos(u)) + 3.0
    tau = _angle(np.where(t2 < 0.0, t1 + np.pi, t1))
    return tau, _angle(tau - u + v - phi)


def _lrlr_same(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.7: L+ R+ L- R-, both middle arcs alike."""
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho = 0.25 * (2.0 + np.hypot(xi, eta))
    u = np.arccos(np.where(rho <= 1.0, rho, np.nan))
    t, v = _tau_omega(u, -u, xi, eta, phi)
    return (t, u, -u, v), _positive(t, -v, u)


def _lrlr_back(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.8: L+ R- L- R+, both middle arcs alike."""
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho = (20.0 - xi * xi - eta * eta) / 16.0
    u = -np.arccos(np.where((rho >= 0.0) & (rho <= 1.0), rho, np.nan))
    t, v = _tau_omega(u, u, xi, eta, phi)
    return (t, u, u, v), _positive(t, v, -u)


def _lrsl(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.9: L+ R-(pi/2) S- L-."""
    rho, theta = _polar(x - np.sin(phi), y - 1.0 + np.cos(phi))
    r = np.sqrt(np.where(rho >= 2.0, rho * rho - 4.0, np.nan))
    u = 2.0 - r
    t = _angle(theta + np.arctan2(r, -2.0))
    v = _angle(phi - QUARTER - t)
    return (t, -QUARTER, u, v), _positive(t, -u, -v)


def _lrsr(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.10: L+ R-(pi/2) S- R-."""
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho, t = _polar(-eta, xi)
    u = 2.0 - rho
    v = _angle(t + QUARTER - phi)
    return (t, -QUARTER, u, v), _positive(t, -u, -v)


def _lrslr(x: Array, y: Array, phi: Array) -> tuple[Lengths, Array]:
    """8.11: L+ R-(pi/2) S- L-(pi/2) R+."""
    xi, eta = x + np.sin(phi), y - 1.0 - np.cos(phi)
    rho = np.hypot(xi, eta)
    u = 4.0 - np.sqrt(np.where(rho >= 2.0, rho * rho - 4.0, np.nan))
    t = _angle(np.arctan2((4.0 - u) * xi - 2.0 * eta, -2.0 * xi + (u - 4.0) * eta))
    v = _angle(t - phi)
    return (t, -QUARTER, u, -QUARTER, v), _positive(t, -u, v)


_FAMILIES: tuple[tuple[str, Formula, bool], ...] = (
    ("LSL", _lsl, False),
    ("LSR", _lsr, False),
    ("LRL", _lrl, False),
    ("LRL", _lrl, True),
    ("LRLR", _lrlr_same, False),
    ("LRLR", _lrlr_back, False),
    ("LRSL", _lrsl, False),
    ("LRSR", _lrsr, False),
    ("LRSL", _lrsl, True),
    ("LRSR", _lrsr, True),
    ("LRSLR", _lrslr, False),
)
"""Word of a formula, and whether it is driven the other way round."""


def _all_words() -> tuple[str, ...]:
    """The words in the order in which `reeds_shepp` looks at them: as they are and reflected, forwards and flipped."""
    found = []
    for word, _, backwards in _FAMILIES:
        plain = word[::-1] if backwards else word
        found += [plain, plain.translate(str.maketrans("LR", "RL"))] * 2
    return tuple(found)


REEDS_SHEPP_WORDS = _all_words()
"""What the pieces of a curve do; those of three arcs stand for two signs each."""
