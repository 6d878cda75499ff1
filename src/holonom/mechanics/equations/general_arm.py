"""Where any three revolute joints bring a point: a quartic (Pieper 1968; Craig, Introduction to Robotics, 4.6).

E1 E2 E3 c = w. Joint 2 keeps the height along its axis and the distance from its point, two equations that are linear
in cos q1, sin q1 and in cos q3, sin q3. Solved for the first pair, u and v, they leave u^2 + v^2 = 1 for q3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from holonom.mechanics.equations.subproblems import (
    FREE,
    Branch,
    Screw,
    Truth,
    Turn,
    followed_by,
    moved,
    reverse,
    rotated,
    turn_onto,
    unit,
)
from holonom.mechanics.equations.vectors import Vector, cross, dot, scale, sub
from holonom.trace import Number, absolute, atan2, cos, less, less_equal, maximum, minimum, select, sqrt

__all__ = ["general", "quartic_roots"]

POLISH = 4
"""Newton steps on the circle after the closed form, each of at most 0.1 rad."""


class _Line(NamedTuple):
    """k0 + k1 cos + k2 sin."""

    k0: Number
    k1: Number
    k2: Number

    def at(self, t: Turn) -> Number:
        return self.k0 + self.k1 * t.c + self.k2 * t.s

    def slope(self, t: Turn) -> Number:
        return self.k2 * t.c - self.k1 * t.s


def general(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Four branches, in no order; those of a complex pair do not reach w."""
    first, second, third = screws
    target, d = sub(w, first.p), sub(second.p, first.p)
    u, v, free = _first_turn(screws, c, target, d)
    branches = []
    for q3 in _on_circle(u, v):
        back, _ = unit(u.at(q3), v.at(q3))
        x = sub(moved(third, q3, c), second.p)
        q2, loose = turn_onto(second.h, x, sub(rotated(first.h, back, target), d), second.rest)
        branches.append(Branch([reverse(back), q2, q3], free | loose))
    return branches


def _first_turn(screws: Sequence[Screw], c: Vector, target: Vector, d: Vector) -> tuple[_Line, _Line, Truth]:
    """cos(-q1) and sin(-q1) as lines in q3, and whether joint 1 is free."""
    first, second, third = screws
    h1, h2, h3 = first.h, second.h, third.h
    e, f, along = sub(third.p, second.p), sub(c, third.p), dot(h1, target)
    side, side3 = cross(h1, target), cross(h3, f)
    flat, flat3, fixed = cross(side, h1), cross(side3, h3), scale(dot(h3, f), h3)
    height = _Line(
        dot(h2, sub(third.p, first.p)) + dot(h2, fixed) - dot(h2, h1) * along, dot(h2, flat3), dot(h2, side3)
    )
    half = 0.5 * (dot(target, target) + dot(d, d) - dot(e, e) - dot(f, f))
    distance = _Line(half - dot(e, fixed) - dot(d, h1) * along, -dot(e, flat3), -dot(e, side3))
    a, b, p, q = dot(h2, flat), dot(h2, side), dot(d, flat), dot(d, side)
    free = less_equal(dot(side, side), FREE * FREE)
    k = 1.0 / select(free, 1.0, a * q - b * p)
    u = _Line(*((m * q - n * b) * k for m, n in zip(height, distance, strict=True)))
    v = _Line(*((n * a - m * p) * k for m, n in zip(height, distance, strict=True)))
    return u, v, free


def _on_circle(u: _Line, v: _Line) -> list[Turn]:
    """The four turns with u^2 + v^2 = 1.

    The half-angle's tangent makes a quartic. Its leading coefficient is the function opposite to where angles are
    counted from: of five places round the circle one has it large, for five values determine such a function.
    """
    start, best = Turn(1.0, 0.0), _residual(u, v, Turn(-1.0, 0.0))
    for k in range(1, 5):
        place = Turn(math.cos(0.4 * math.pi * k), math.sin(0.4 * math.pi * k))
        value = _residual(u, v, Turn(-place.c, -place.s))
        larger = less(absolute(best), absolute(value))
        start = Turn(select(larger, place.c, start.c), select(larger, place.s, start.s))
        best = select(larger, value, best)
    (u0, u1, u2), (v0, v1, v2) = _in_tangent(u, start), _in_tangent(v, start)
    lead = 1.0 / (u2 * u2 + v2 * v2 - 1.0)
    roots = quartic_roots(
        2.0 * (u2 * u1 + v2 * v1) * lead,
        (u1 * u1 + v1 * v1 + 2.0 * (u2 * u0 + v2 * v0) - 2.0) * lead,
        2.0 * (u1 * u0 + v1 * v0) * lead,
        (u0 * u0 + v0 * v0 - 1.0) * lead,
    )
    return [_polished(u, v, followed_by(start, unit(1.0 - t * t, 2.0 * t)[0])) for t in roots]


def _residual(u: _Line, v: _Line, t: Turn) -> Number:
    a, b = u.at(t), v.at(t)
    return a * a + b * b - 1.0


def _in_tangent(line: _Line, start: Turn) -> tuple[Number, Number, Number]:
    """Coefficients of (1 + t^2) times the line, t the tangent of half the angle from `start`."""
    along, across = line.at(start) - line.k0, line.slope(start)
    return line.k0 + along, 2.0 * across, line.k0 - along


def _polished(u: _Line, v: _Line, t: Turn) -> Turn:
    for _ in range(POLISH):
        slope = 2.0 * (u.at(t) * u.slope(t) + v.at(t) * v.slope(t))
        flat = less(absolute(slope), 1e-12)
        step = -_residual(u, v, t) / select(flat, 1.0, slope)
        t = followed_by(t, unit(1.0, minimum(maximum(step, -0.1), 0.1))[0])
    return t


def quartic_roots(a: Number, b: Number, c: Number, d: Number) -> list[Number]:
    """Roots of t^4 + a t^3 + b t^2 + c t + d (Ferrari); of a complex pair the real part, twice."""
    p = b - 0.375 * a * a
    q = c + a * (0.125 * a * a - 0.5 * b)
    r = d + a * (a * (0.0625 * b - 0.01171875 * a * a) - 0.25 * c)
    z = maximum(_largest_root(2.0 * p, p * p - 4.0 * r, -q * q), 0.0)
    alpha = sqrt(z)
    beta = sqrt(maximum(z * (z + 2.0 * p) + p * p - 4.0 * r, 0.0))  # |q| / alpha, without its 0 / 0
    beta = select(less(q, 0.0), -beta, beta)
    roots: list[Number] = []
    for middle, product in ((-alpha, p + z - beta), (alpha, p + z + beta)):
        root = sqrt(maximum(z - 2.0 * product, 0.0))
        roots += [0.5 * (middle + root) - 0.25 * a, 0.5 * (middle - root) - 0.25 * a]
    return roots


def _largest_root(a: Number, b: Number, c: Number) -> Number:
    """Largest real root of z^3 + a z^2 + b z + c (Viete; Cardano)."""
    third = a * (1.0 / 3.0)
    P = (b - a * third) * (1.0 / 3.0)
    Q = 0.5 * (c + third * (2.0 * third * third - b))
    square = Q * Q + P * P * P
    three = 2.0 * sqrt(maximum(-P, 0.0)) * cos(atan2(sqrt(maximum(-square, 0.0)), -Q) * (1.0 / 3.0))
    w = _cube_root(absolute(Q) + sqrt(maximum(square, 0.0)))
    w = maximum(w, 1e-100)
    one = w - P / w
    return select(less(square, 0.0), three, select(less(0.0, Q), -one, one)) - third


def _cube_root(x: Number) -> Number:
    """x^(1/3) for x >= 0: x^(1/4 + 1/16 + 1/64 + 1/256), then Halley's steps."""
    x = maximum(x, 1e-250)
    y: Number = 1.0
    power = x
    for _ in range(4):
        power = sqrt(sqrt(power))
        y = y * power
    for _ in range(3):
        cube = y * y * y
        y = y * ((cube + 2.0 * x) / (2.0 * cube + x))
    return y
