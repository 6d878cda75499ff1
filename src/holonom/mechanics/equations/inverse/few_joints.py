"""Inverse of arms with four or five revolute joints, which reach only some poses: others fail the proof by fk.

G = (R, p) = E1 ... En, the motion from the home pose. The families are those of EAIK (Ostermeier et al. 2024).
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.inverse.parallel_axes import planar_pose, remaining
from holonom.mechanics.equations.inverse.regional import Regional
from holonom.mechanics.equations.inverse.spherical_wrist import across
from holonom.mechanics.equations.inverse.subproblems import (
    Branch,
    Screw,
    Turn,
    Value,
    moved,
    reverse,
    rotated,
    turn_onto,
    turns_to_level,
    two_parallel_turns,
    unrotated,
)
from holonom.mechanics.equations.vectors import Pose, Vector, add, dot, matvec, sub, tvec
from holonom.trace import Number

__all__ = ["middle_meeting", "middle_parallel", "planar_shoulder", "short_wrist"]


def short_wrist(screws: Sequence[Screw], regional: Regional, G: Pose) -> list[Branch]:
    """Joints 1 to 3 bring a point of axis 4 (on axis 5 too) to its place, the rest of the turn gives joint 4, and 5."""
    R, p = G
    arm, wrist = list(screws[:3]), screws[3:]
    c, h4 = wrist[0].p, wrist[0].h
    seen = across(h4) if len(wrist) == 1 else wrist[1].h
    branches = []
    for reached in regional(arm, c, add(matvec(R, c), p)):
        q4, free = turn_onto(h4, seen, unrotated(arm, reached.values, matvec(R, seen)), wrist[0].rest)
        values: list[Value] = [*reached.values, q4]
        if len(wrist) == 2:
            x = across(wrist[1].h)
            q5, _ = turn_onto(wrist[1].h, x, unrotated([*arm, wrist[0]], values, matvec(R, x)), wrist[1].rest)
            values.append(q5)
        branches.append(Branch(values, reached.free | free))
    return branches


def middle_parallel(screws: Sequence[Screw], G: Pose) -> list[Branch]:
    """Five joints, 2, 3 and 4 parallel: they keep the height of a point of axis 5 along them, which gives q1."""
    R, p = G
    first, parallel, last = screws[0], screws[1:4], screws[4]
    h, x = parallel[0].h, across(parallel[0].h)
    target = sub(add(matvec(R, last.p), p), first.p)
    turns, free = turns_to_level(first.h, target, h, dot(h, sub(last.p, first.p)), reverse(first.rest))
    branches = []
    for turn in turns:
        R1 = [rotated(first.h, turn, column) for column in zip(*R, strict=True)]  # columns of R1^T R
        q5, loose = turn_onto(last.h, matvec(R1, h), h, last.rest)
        back5 = reverse(q5)
        total, _ = turn_onto(h, x, tvec(R1, rotated(last.h, back5, x)))
        c = moved(last, back5, parallel[2].p)
        w = add(first.p, rotated(first.h, turn, sub(add(matvec(R, c), p), first.p)))
        for triangle in two_parallel_turns(parallel[0], parallel[1], parallel[2].p, w):
            q4 = remaining(total, h, parallel, triangle.values)
            branches.append(Branch([reverse(turn), *triangle.values, q4, q5], free | loose | triangle.free))
    return branches


def middle_meeting(screws: Sequence[Screw], regional: Regional, G: Pose) -> list[Branch]:
    """Five joints, 3 and 4 meet in the point c of both screws: E5'(q5) E1 E2 c = G c, where axis 5' is G axis 5."""
    R, p = G
    first, second, third, fourth, last = screws
    c = third.p
    carried = Screw(True, matvec(R, last.h), add(matvec(R, last.p), p), last.rest)  # type: ignore[arg-type]
    branches = []
    for reached in regional([carried, first, second], c, add(matvec(R, c), p)):
        q5, q1, q2 = reached.values
        assert isinstance(q5, Turn)

        def inner(v: Vector, q5: Turn = q5, values: Sequence[Value] = (q1, q2)) -> list[Number]:
            """R2^T R1^T R R5^T v = R3 R4 v."""
            return unrotated([first, second], list(values), matvec(R, rotated(last.h, reverse(q5), v)))

        q3, free = turn_onto(third.h, fourth.h, inner(fourth.h), third.rest)
        x = across(fourth.h)
        q4, _ = turn_onto(fourth.h, x, rotated(third.h, reverse(q3), inner(x)), fourth.rest)
        branches.append(Branch([q1, q2, q3, q4, q5], reached.free | free))
    return branches


def planar_shoulder(screws: Sequence[Screw], G: Pose, *, meeting: bool) -> list[Branch]:
    """Joints 1, 2 and 3 parallel, then one or two: what those keep is a height along h or, meeting, a direction."""
    R, p = G
    arm, wrist = screws[:3], screws[3:]
    h = arm[0].h
    u = tvec(R, h)  # R^T h = R5^T R4^T h
    if len(wrist) == 1:
        q4, free = turn_onto(wrist[0].h, u, h, wrist[0].rest)
        ends: list[list[Turn]] = [[q4]]
    else:
        s4, s5 = wrist
        if meeting:
            turns, free = turns_to_level(s4.h, h, s5.h, dot(s5.h, u), reverse(s4.rest))
            fourth = [reverse(turn) for turn in turns]
        else:
            o = s5.p
            level = dot(h, sub(add(matvec(R, o), p), s4.p))
            fourth, free = turns_to_level(s4.h, sub(o, s4.p), h, level, s4.rest)
        ends = [[q4, turn_onto(s5.h, u, rotated(s4.h, reverse(q4), h), s5.rest)[0]] for q4 in fourth]
    branches = []
    for values in ends:
        columns = [_undone(wrist, values, e) for e in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        R3 = [matvec(R, column) for column in columns]
        c = arm[2].p
        inner: Vector = c
        for screw, value in zip(wrist, values, strict=True):
            inner = moved(screw, reverse(value), inner)
        rows = [list(row) for row in zip(*R3, strict=True)]
        place = sub(add(matvec(R, inner), p), matvec(rows, c))
        branches += [Branch([*b.values, *values], b.free | free) for b in planar_pose(arm, (rows, place))]
    return branches


def _undone(screws: Sequence[Screw], values: Sequence[Turn], v: Vector) -> Vector:
    """R5^T R4^T v."""
    for screw, value in zip(screws, values, strict=True):
        v = rotated(screw.h, reverse(value), v)
    return v
