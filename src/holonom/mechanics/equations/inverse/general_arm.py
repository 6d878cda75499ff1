"""Where any three revolute joints bring a point: a quartic (Pieper 1968; Craig, Introduction to Robotics, 4.6).

E1 E2 E3 c = w. Joint 2 keeps the height along its axis and the distance from its point, two equations that are linear
in cos q1, sin q1 and in cos q3, sin q3. Solved for the first pair, u and v, they leave u^2 + v^2 = 1 for q3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from holonom.mechanics.equations.inverse.subproblems import (
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

__all__ = ["NAMES", "Line", "general", "in_order", "on_circle", "quartic_roots", "round_order"]

NAMES = ("det+ first", "det+ second", "det- first", "det- second")
COMPLEX = 1e-4
"""Imaginary part of q3 (rad, about) from where on two roots are a complex pair, and no double root but for rounding."""


POLISH = 4
"""Newton steps on the circle after the closed form, each of at most 0.1 rad."""


class Line(NamedTuple):
    """k0 + k1 cos + k2 sin."""

    k0: Number
    k1: Number
    k2: Number

    def at(self, t: Turn) -> Number:
        """Its value."""
        return self.k0 + self.k1 * t.c + self.k2 * t.s

    def slope(self, t: Turn) -> Number:
        """Its derivative by the angle."""
        return self.k2 * t.c - self.k1 * t.s


def general(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Four branches, in the order of `NAMES`.

    First come those in which the determinant of the point's Jacobian is positive, then the negative ones. A pair of
    roots that meet and part has one of each, so that reached branches keep this half as long as they are not singular;
    there are as many of the one as of the other. Within a half, that with the smaller q3 in (-pi, pi) from the home
    position comes first, and roots of a complex pair, which do not reach w, come last.
    """
    first, second, third = screws
    target, d = sub(w, first.p), sub(second.p, first.p)
    u, v, free = _first_turn(screws, c, target, d)
    placed = []
    for k, (q3, real) in enumerate(on_circle(u, v)):
        back, _ = unit(u.at(q3), v.at(q3))
        y, x = sub(rotated(first.h, back, target), d), sub(moved(third, q3, c), second.p)
        q2, loose = turn_onto(second.h, x, y, second.rest)
        lever = rotated(second.h, q2, cross(third.h, sub(moved(third, q3, c), third.p)))
        determinant = dot(cross(cross(first.h, [a + b for a, b in zip(y, d, strict=True)]), cross(second.h, y)), lever)
        half = select(real, select(less(determinant, 0.0), 1.0, 0.0), float(k % 2))
        place = 8.0 * half + select(real, round_order(q3), 3.0)
        placed.append((place, Branch([reverse(back), q2, q3], free | loose)))
    return in_order(placed)


def round_order(t: Turn) -> Number:
    """A number in [-2, 2] that grows with the angle from -pi to pi."""
    return select(less(t.s, 0.0), t.c - 1.0, 1.0 - t.c)


def in_order(placed: Sequence[tuple[Number, Branch]]) -> list[Branch]:
    """Four branches by their places: a sorting network, for a traced program has no other."""
    rows = [[place, *(x for turn in b.values for x in turn), select(b.free, 1.0, 0.0)] for place, b in placed]  # type: ignore[union-attr]
    for i, j in ((0, 1), (2, 3), (0, 2), (1, 3), (1, 2)):
        over = less(rows[j][0], rows[i][0])
        both = list(zip(rows[i], rows[j], strict=True))
        rows[i], rows[j] = [select(over, b, a) for a, b in both], [select(over, a, b) for a, b in both]
    return [
        Branch([Turn(c1, s1), Turn(c2, s2), Turn(c3, s3)], less(0.5, free)) for _, c1, s1, c2, s2, c3, s3, free in rows
    ]


def _first_turn(screws: Sequence[Screw], c: Vector, target: Vector, d: Vector) -> tuple[Line, Line, Truth]:
    """cos(-q1) and sin(-q1) as lines in q3, and whether joint 1 is free."""
    first, second, third = screws
    h1, h2, h3 = first.h, second.h, third.h
    e, f, along = sub(third.p, second.p), sub(c, third.p), dot(h1, target)
    side, side3 = cross(h1, target), cross(h3, f)
    flat, flat3, fixed = cross(side, h1), cross(side3, h3), scale(dot(h3, f), h3)
    height = Line(dot(h2, sub(third.p, first.p)) + dot(h2, fixed) - dot(h2, h1) * along, dot(h2, flat3), dot(h2, side3))
    half = 0.5 * (dot(target, target) + dot(d, d) - dot(e, e) - dot(f, f))
    distance = Line(half - dot(e, fixed) - dot(d, h1) * along, -dot(e, flat3), -dot(e, side3))
    a, b, p, q = dot(h2, flat), dot(h2, side), dot(d, flat), dot(d, side)
    free = less_equal(dot(side, side), FREE * FREE)
    k = 1.0 / select(free, 1.0, a * q - b * p)
    u = Line(*((m * q - n * b) * k for m, n in zip(height, distance, strict=True)))
    v = Line(*((n * a - m * p) * k for m, n in zip(height, distance, strict=True)))
    return u, v, free


def on_circle(u: Line, v: Line) -> list[tuple[Turn, Truth]]:
    """The four turns with u^2 + v^2 = 1, and whether they are real; of a complex pair the real part, twice.

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
    found = []
    for t, imaginary in roots:
        q3 = followed_by(start, unit(1.0 - t * t, 2.0 * t)[0])
        polished, real = _polished(u, v, q3), less_equal(imaginary, COMPLEX * (t * t + 1.0))
        # Polished, a complex root would slide to a real one and stand there twice.
        found.append((Turn(select(real, polished.c, q3.c), select(real, polished.s, q3.s)), real))
    return found


def _residual(u: Line, v: Line, t: Turn) -> Number:
    a, b = u.at(t), v.at(t)
    return a * a + b * b - 1.0


def _in_tangent(line: Line, start: Turn) -> tuple[Number, Number, Number]:
    """Coefficients of (1 + t^2) times the line, t the tangent of half the angle from `start`."""
    along, across = line.at(start) - line.k0, line.slope(start)
    return line.k0 + along, 2.0 * across, line.k0 - along


def _polished(u: Line, v: Line, t: Turn) -> Turn:
    for _ in range(POLISH):
        slope = 2.0 * (u.at(t) * u.slope(t) + v.at(t) * v.slope(t))
        flat = less(absolute(slope), 1e-12)
        step = -_residual(u, v, t) / select(flat, 1.0, slope)
        t = followed_by(t, unit(1.0, minimum(maximum(step, -0.1), 0.1))[0])
    return t


def quartic_roots(a: Number, b: Number, c: Number, d: Number) -> list[tuple[Number, Number]]:
    """Roots of t^4 + a t^3 + b t^2 + c t + d (Ferrari): real parts, and magnitudes of the imaginary ones."""
    p = b - 0.375 * a * a
    q = c + a * (0.125 * a * a - 0.5 * b)
    r = d + a * (a * (0.0625 * b - 0.01171875 * a * a) - 0.25 * c)
    z = maximum(_largest_root(2.0 * p, p * p - 4.0 * r, -q * q), 0.0)
    alpha = sqrt(z)
    beta = sqrt(maximum(z * (z + 2.0 * p) + p * p - 4.0 * r, 0.0))  # |q| / alpha, without its 0 / 0
    beta = select(less(q, 0.0), -beta, beta)
    roots: list[tuple[Number, Number]] = []
    for middle, product in ((-alpha, p + z - beta), (alpha, p + z + beta)):
        square = z - 2.0 * product
        root, imaginary = sqrt(maximum(square, 0.0)), 0.5 * sqrt(maximum(-square, 0.0))
        roots += [(0.5 * (middle + way) - 0.25 * a, imaginary) for way in (root, -root)]
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
