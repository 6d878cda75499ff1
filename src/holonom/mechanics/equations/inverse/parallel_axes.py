"""Inverse of arms with three parallel axes: the UR family, planar arms, SCARA (Elias & Wen 2022; Hawkins 2013).

G = T_0n M^-1 = (R, p) = E1 ... En: the motion from the home pose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from holonom.mechanics.equations.inverse.spherical_wrist import across, sine_square
from holonom.mechanics.equations.inverse.subproblems import (
    Branch,
    Screw,
    Turn,
    Value,
    followed_by,
    reverse,
    rotated,
    turn_onto,
    turns_to_level,
    two_parallel_turns,
)
from holonom.mechanics.equations.vectors import Pose, Vector, add, cross, dot, matvec, scale, sub, tvec
from holonom.trace import maximum, minimum, sqrt

__all__ = ["planar_point", "planar_pose", "remaining", "three_parallel"]

MARGIN = 1e-3
"""Over the length of links 2 and 3: by what joint 4 stays away from where they fold back upon each other."""


def three_parallel(screws: Sequence[Screw], G: Pose) -> list[Branch]:
    """Axes 2, 3 and 4 parallel, 5 and 6 meet in the point both screws name (UR): eight branches.

    That point moves with joints 1 to 4 only, and joints 2 to 4 keep its height along them: q1. The height of the tool
    axis gives q5, the direction of the parallel axes q6; joints 2 to 4 are then a planar arm. Where the tool axis is
    parallel to them q6 is free; joint 4 is then brought as near to the shoulder as links 2 and 3 let it come.
    """
    R, p = G
    first, parallel, wrist = screws[0], screws[1:4], screws[4:]
    o, h = wrist[0].p, parallel[0].h
    target = sub(add(matvec(R, o), p), first.p)
    turns, free = turns_to_level(first.h, target, h, dot(h, sub(o, first.p)), reverse(first.rest))
    branches = []
    for back in turns:
        R1 = [rotated(first.h, back, column) for column in zip(*R, strict=True)]
        behind = add(first.p, rotated(first.h, back, target))
        for branch in _two_to_six(parallel, wrist, R1, behind):
            branches.append(Branch([reverse(back), *branch.values], free | branch.free))
    return branches


def _two_to_six(parallel: Sequence[Screw], wrist: Sequence[Screw], C: Sequence[Vector], o: Vector) -> list[Branch]:
    """Joints 2 to 6 from what they make of the frame: the columns C of R1^T R, and o, where the wrist's point goes."""
    (s2, s3, s4), (s5, s6) = parallel, wrist
    h, x = s2.h, across(s2.h)
    lengths = [math.dist(b.p, a.p) for a, b in ((s2, s3), (s3, s4))]
    least = abs(lengths[0] - lengths[1]) + MARGIN * sum(lengths)
    u = tvec(C, s6.h)
    turns, _ = turns_to_level(s5.h, s6.h, h, dot(h, u), s5.rest, sine_square=sine_square(h, s5.h, s6.h, u))
    branches = []
    for q5 in turns:
        back5 = reverse(q5)
        arm = rotated(s5.h, back5, sub(s4.p, s5.p))
        folded = _folded(s6, arm, [dot(c, sub(s2.p, o)) for c in C], least)
        back6, free = turn_onto(s6.h, rotated(s5.h, back5, h), [dot(c, h) for c in C], folded)
        carried = [rotated(s6.h, back6, v) for v in (rotated(s5.h, back5, x), arm)]
        total, _ = turn_onto(h, x, tvec(C, carried[0]))
        for triangle in two_parallel_turns(s2, s3, s4.p, add(o, tvec(C, carried[1]))):
            values = [*triangle.values, remaining(total, h, parallel, triangle.values), q5, reverse(back6)]
            branches.append(Branch(values, free | triangle.free))
    return branches


def _folded(last: Screw, arm: Vector, shoulder: Vector, least: float) -> Turn:
    """The turn back about the last axis that brings joint 4 (`arm`) to the shoulder, but for `least`.

    Both are seen from the last axis: the law of cosines in the plane across it.
    """
    onto, _ = turn_onto(last.h, arm, shoulder, reverse(last.rest))
    a, b = (cross(last.h, v) for v in (arm, shoulder))
    aa, bb = dot(a, a), dot(b, b)
    size = sqrt(maximum(aa * bb, 1e-30))
    cosine = maximum(minimum((0.5 / size) * (aa + bb - least * least), 1.0), -1.0)
    return followed_by(onto, Turn(cosine, sqrt(maximum(1.0 - cosine * cosine, 0.0))))


def remaining(total: Turn, h: Vector, screws: Sequence[Screw], values: Sequence[Value]) -> Turn:
    """The last value of joints parallel to h that turn by `total` about h together, from those of the others."""
    signs = [float(dot(h, s.h)) for s in screws]
    for sign, value in zip(signs[:-1], values, strict=True):
        assert isinstance(value, Turn)
        total = followed_by(total, reverse(value) if sign > 0.0 else value)
    return total if signs[-1] > 0.0 else reverse(total)


def planar_pose(screws: Sequence[Screw], G: Pose) -> list[Branch]:
    """Three parallel revolute joints and, anywhere among them, at most one that slides along them (3R, SCARA)."""
    R, p = G
    turning = [s for s in screws if s.revolute]
    h, third = turning[0].h, turning[2]
    x = across(h)
    total, _ = turn_onto(h, x, matvec(R, x))
    branches = []
    for triangle in _triangles(screws, third.p, add(matvec(R, third.p), p)):
        last = remaining(total, h, turning, triangle.values[:2])
        branches.append(Branch(_sorted(screws, [*triangle.values[:2], last, *triangle.values[2:]]), triangle.free))
    return branches


def planar_point(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Two parallel revolute joints, and at most one that slides along them, bring the point c to w."""
    return [Branch(_sorted(screws, b.values), b.free) for b in _triangles(screws, c, w)]


def _triangles(screws: Sequence[Screw], c: Vector, w: Vector) -> list[Branch]:
    """Two turns that bring c to w, then the way of the joint that slides, if there is one."""
    first, second = [s for s in screws if s.revolute][:2]
    sliding = [s for s in screws if not s.revolute]
    if not sliding:
        return two_parallel_turns(first, second, c, w)
    way = dot(first.h, sub(w, c))
    ways: list[Value] = [way * float(dot(first.h, sliding[0].h))]
    found = two_parallel_turns(first, second, c, sub(w, scale(way, first.h)))
    return [Branch(b.values + ways, b.free) for b in found]


def _sorted(screws: Sequence[Screw], values: Sequence[Value]) -> list[Value]:
    """Values of the revolute joints, then of those that slide, in the order of the joints."""
    turning = sum(s.revolute for s in screws)
    turns, ways = iter(values[:turning]), iter(values[turning:])
    return [next(turns) if s.revolute else next(ways) for s in screws]
