"""Inverse of arms with three parallel axes 2, 3 and 4 whose last two axes need not meet (Elias & Wen, IK-Geo, 2022).

G = (R, p) = E1 ... E6, the motion from the home pose. Joints 2 to 4 keep directions along h and heights along it, so
what E1^-1 G makes of axis 6 and of a point on it has the same height as what E5 makes of them: two equations, linear
in cos q1, sin q1 and in cos q5, sin q5. Solved for the first pair they leave a quartic for q5, as for any three joints.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.inverse.general_arm import Line, in_order, on_circle, round_order
from holonom.mechanics.equations.inverse.parallel_axes import remaining
from holonom.mechanics.equations.inverse.spherical_wrist import across
from holonom.mechanics.equations.inverse.subproblems import (
    FREE,
    Branch,
    Screw,
    Truth,
    Turn,
    moved,
    reverse,
    rotated,
    turn_onto,
    turns_to_level,
    two_parallel_turns,
    unit,
)
from holonom.mechanics.equations.vectors import Pose, Vector, add, cross, dot, matvec, scale, sub, tvec
from holonom.trace import absolute, less_equal, select

__all__ = ["three_parallel_and_two", "three_parallel_skew"]


def three_parallel_skew(screws: Sequence[Screw], G: Pose) -> list[Branch]:
    """Eight branches: the real roots by q5 from -pi to pi of the home pose, each with both elbows."""
    R, p = G
    first, h, (s5, s6) = screws[0], screws[1].h, screws[4:]
    loose, q5_of = _first_and_fifth(first, h, s5, s6, matvec(R, s6.h), add(matvec(R, s6.p), p))
    solved = []
    for root, real in on_circle(*q5_of):
        back, _ = unit(q5_of[0].at(root), q5_of[1].at(root))
        solved.append((select(real, round_order(root), 3.0), Branch([back, root, root], loose)))
    branches = []
    for branch in in_order(solved):
        turn, q5, _ = branch.values
        assert isinstance(turn, Turn)
        assert isinstance(q5, Turn)
        branches += _others(screws, G, turn, q5, loose)
    return branches


def three_parallel_and_two(screws: Sequence[Screw], G: Pose) -> list[Branch]:
    """Eight branches where axes 5 and 6 are parallel: joint 5 does not tilt axis 6, so one equation is q1's alone."""
    R, p = G
    first, h, s5, s6 = screws[0], screws[1].h, screws[4], screws[5]
    turns, free = turns_to_level(first.h, matvec(R, s6.h), h, dot(h, s6.h), reverse(first.rest))
    o = sub(add(matvec(R, s6.p), p), first.p)
    branches = []
    for turn in turns:
        level = dot(h, sub(add(first.p, rotated(first.h, turn, o)), s5.p))
        fifth, loose = turns_to_level(s5.h, sub(s6.p, s5.p), h, level, s5.rest)
        for q5 in fifth:
            branches += _others(screws, G, turn, q5, free | loose)
    return branches


def _others(screws: Sequence[Screw], G: Pose, turn: Turn, q5: Turn, free: Truth) -> list[Branch]:
    """Both branches with q1, turned back by `turn`, and q5: joint 6, and joints 2 to 4 as a planar arm."""
    R, p = G
    first, parallel, (s5, s6) = screws[0], screws[1:4], screws[4:]
    h = parallel[0].h
    R1 = [rotated(first.h, turn, column) for column in zip(*R, strict=True)]  # columns of R1^T R
    back5 = reverse(q5)
    q6, _ = turn_onto(s6.h, matvec(R1, h), rotated(s5.h, back5, h), s6.rest)
    x = across(h)
    total, _ = turn_onto(h, x, tvec(R1, rotated(s6.h, reverse(q6), rotated(s5.h, back5, x))))
    c = moved(s6, reverse(q6), moved(s5, back5, parallel[2].p))
    w = add(first.p, rotated(first.h, turn, sub(add(matvec(R, c), p), first.p)))
    found = []
    for triangle in two_parallel_turns(parallel[0], parallel[1], parallel[2].p, w):
        last = remaining(total, h, parallel, triangle.values)
        found.append(Branch([reverse(turn), *triangle.values, last, q5, q6], triangle.free | free))
    return found


def _first_and_fifth(
    first: Screw, h: Vector, s5: Screw, s6: Screw, u: Vector, o: Vector
) -> tuple[Truth, tuple[Line, Line]]:
    """Whether joint 1 is free, and cos(-q1), sin(-q1) as lines in q5; u is R h6, and o = G o6."""
    rows = []
    for x, y, lift in (
        (u, s6.h, 0.0),
        (sub(o, first.p), sub(s6.p, s5.p), dot(h, sub(s5.p, first.p))),
    ):
        along = dot(first.h, x)
        left = Line(dot(first.h, h) * along, dot(h, sub(x, scale(along, first.h))), dot(h, cross(first.h, x)))
        along = dot(s5.h, y)
        right = Line(dot(s5.h, h) * along, dot(h, sub(y, scale(along, s5.h))), dot(h, cross(s5.h, y)))
        rows.append((left, right._replace(k0=right.k0 + lift - left.k0)))
    (a, m), (b, n) = rows
    D = a.k1 * b.k2 - b.k1 * a.k2
    free = less_equal(absolute(D), FREE * FREE)
    k = 1.0 / select(free, 1.0, D)
    cosine = Line(*((b.k2 * s - a.k2 * t) * k for s, t in zip(m, n, strict=True)))
    sine = Line(*((a.k1 * t - b.k1 * s) * k for s, t in zip(m, n, strict=True)))
    return free, (cosine, sine)
