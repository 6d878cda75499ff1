"""Where three joints bring a point: the first three joints of an arm with a spherical wrist, or a 3-joint arm.

Each solver finds E1(q1) E2(q2) E3(q3) c = w, with c the point at the home pose; solvers differ in how the axes lie. The
same equation read from the other end, E3(-q3) E2(-q2) E1(-q1) w = c, gives the mirrored arms (`backwards`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from holonom.mechanics.equations.inverse.subproblems import (
    Branch,
    Screw,
    Value,
    mirrored,
    moved,
    opposite,
    reverse,
    rotated,
    turn_onto,
    turns_to_level,
    two_parallel_turns,
)
from holonom.mechanics.equations.vectors import Vector, add, dot, scale, sub
from holonom.trace import maximum, sqrt

__all__ = ["Regional", "backwards", "meeting_12", "parallel_12_slide", "parallel_23", "two_turns"]

Regional = Callable[[Sequence[Screw], Vector, Vector], list[Branch]]


def backwards(solver: Regional) -> Regional:
    """The solver of the arm that is built the other way round."""

    def solve(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
        turned = [mirrored(s) for s in reversed(screws)]
        return [Branch([opposite(v) for v in reversed(b.values)], b.free) for b in solver(turned, w, c)]

    return solve


def parallel_23(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Axes 2 and 3 parallel (Puma, KUKA KR, ABB IRB): the height along them gives q1, then a triangle."""
    first, second, third = screws
    w1 = sub(w, first.p)
    back = reverse(first.rest)
    turns, free = turns_to_level(first.h, w1, second.h, dot(second.h, sub(c, first.p)), back)
    branches = []
    for turn in turns:
        y = add(first.p, rotated(first.h, turn, w1))
        for triangle in two_parallel_turns(second, third, c, y):
            branches.append(Branch([opposite(turn), *triangle.values], free | triangle.free))
    return branches


def two_turns(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Two joints, whatever their axes: the first brings c to the height that the second keeps, or they make a triangle.

    A point that they do not reach fails the proof.
    """
    first, second = screws
    if first.h in (second.h, tuple(-x for x in second.h)):
        return two_parallel_turns(first, second, c, w)
    back = reverse(first.rest)
    w1 = sub(w, first.p)
    turns, free = turns_to_level(first.h, w1, second.h, dot(second.h, sub(c, first.p)), back)
    branches = []
    for turn in turns:
        y = sub(add(first.p, rotated(first.h, turn, w1)), second.p)
        q2, loose = turn_onto(second.h, sub(c, second.p), y, second.rest)
        branches.append(Branch([opposite(turn), q2], free | loose))
    return branches


def parallel_12_slide(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Axes 1 and 2 parallel, joint 3 prismatic: the height along them gives q3, then a triangle."""
    first, second, third = screws
    q3 = dot(first.h, sub(w, c)) * (1.0 / float(dot(first.h, third.h)))
    x = add(c, scale(q3, third.h))
    return [Branch([*b.values, q3], b.free) for b in two_parallel_turns(first, second, x, w)]


def meeting_12(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Axes 1 and 2 meet in the point both screws name: the distance from it gives q3, then two turns about it."""
    first, second, third = screws
    o = first.p
    target = sub(w, o)
    branches = []
    for q3, loose in _at_distance(third, c, o, target):
        x = sub(moved(third, q3, c), o)
        back = reverse(first.rest)
        turns, free = turns_to_level(first.h, target, second.h, dot(second.h, x), back)
        for turn in turns:
            q2, spin = turn_onto(second.h, x, rotated(first.h, turn, target), second.rest)
            branches.append(Branch([opposite(turn), q2, q3], loose | free | spin))
    return branches


def _at_distance(joint: Screw, c: Vector, o: Vector, target: Vector) -> list[tuple[Value, bool]]:
    """Both positions of a joint that bring the point c as far from o as the target is."""
    if not joint.revolute:
        f = sub(c, o)
        along = dot(joint.h, f)
        root = sqrt(maximum(dot(target, target) - dot(f, f) + along * along, 0.0))
        return [(root - along, False), (-root - along, False)]
    e, f = sub(joint.p, o), sub(c, joint.p)
    reach = 0.5 * (dot(target, target) - dot(e, e) - dot(f, f))
    turns, free = turns_to_level(joint.h, f, e, reach, joint.rest)
    return [(turn, free) for turn in turns]  # type: ignore[misc]
