"""The few angles that closed-form inverses are made of (Paden 1986; Elias & Wen, IK-Geo, 2022), without a branch.

An unknown angle is a `Turn`, its cosine and sine: the arctangent comes once, at the end. Two questions are enough:
which turn brings one vector upon another (`turn_onto`), and which two turns bring a vector to a given height along
another one (`turns_to_level`). The distance of two points (IK-Geo's subproblem 3) is such a height.
"""

from __future__ import annotations

from typing import NamedTuple

from holonom.mechanics.equations.vectors import Vector, add, cross, dot, scale, sub
from holonom.trace import Condition, Number, less_equal, maximum, select, sqrt

__all__ = [
    "FREE",
    "NO_TURN",
    "Branch",
    "Screw",
    "Truth",
    "Turn",
    "Value",
    "followed_by",
    "mirrored",
    "moved",
    "opposite",
    "reverse",
    "rotated",
    "turn_onto",
    "turns_to_level",
    "two_parallel_turns",
    "unit",
    "unrotated",
]

Truth = Condition | bool
FREE = 1e-9
"""Length (m) or sine below which an angle has nothing to hold on to: it is free, and its `rest` is taken."""


class Turn(NamedTuple):
    """Cosine and sine of an angle."""

    c: Number
    s: Number


NO_TURN = Turn(1.0, 0.0)
Value = Turn | Number
"""A revolute joint's turn, or a prismatic joint's way in m."""


class Screw(NamedTuple):
    """A joint axis: unit direction, a point on it (m), and the turn that is taken where the joint is free."""

    revolute: bool
    h: tuple[float, float, float]
    p: tuple[float, float, float]
    rest: Turn = NO_TURN


class Branch(NamedTuple):
    """One solution: a value per joint, and whether some joint is free in it."""

    values: list[Value]
    free: Truth


def reverse(turn: Turn) -> Turn:
    """The same angle back."""
    return Turn(turn.c, -turn.s)


def opposite(value: Value) -> Value:
    """The same way back, turned or slid."""
    return reverse(value) if isinstance(value, Turn) else -value


def mirrored(screw: Screw) -> Screw:
    """The axis as it is for the arm that is built the other way round: its joint turns back."""
    return screw._replace(rest=reverse(screw.rest))


def followed_by(a: Turn, b: Turn) -> Turn:
    """The sum of two angles."""
    return Turn(a.c * b.c - a.s * b.s, a.s * b.c + a.c * b.s)


def unit(x: Number, y: Number, rest: Turn = NO_TURN, least: float = FREE) -> tuple[Turn, Truth]:
    """Turn to the point (x, y), and whether that is nearer than `least` to the origin: then `rest` is returned."""
    square = x * x + y * y
    free = less_equal(square, least * least)
    k = 1.0 / sqrt(select(free, 1.0, square))
    return Turn(select(free, rest.c, x * k), select(free, rest.s, y * k)), free


def rotated(h: Vector, turn: Turn, v: Vector) -> list[Number]:
    """R(h, turn) v (Rodrigues), written so that zeros of `h` leave nothing behind."""
    along = scale(dot(h, v), h)
    across = cross(h, v)
    return [a + (turn.c * (x - a) + turn.s * y) for a, x, y in zip(along, v, across, strict=True)]


def unrotated(screws: list[Screw], values: list[Value], v: Vector) -> list[Number]:
    """(R_1 R_2 ...)^T v; neighbours with the same direction turn at once."""
    turns: list[tuple[Vector, Turn]] = []
    for screw, value in zip(screws, values, strict=True):
        if not isinstance(value, Turn):
            continue
        if turns and turns[-1][0] == screw.h:
            turns[-1] = (screw.h, followed_by(turns[-1][1], value))
        else:
            turns.append((screw.h, value))
    for h, turn in turns:
        v = rotated(h, reverse(turn), v)
    return list(v)


def moved(screw: Screw, value: Value, x: Vector) -> list[Number]:
    """The point x, carried by a joint."""
    if isinstance(value, Turn):
        return add(screw.p, rotated(screw.h, value, sub(x, screw.p)))
    return add(x, scale(value, screw.h))


def turn_onto(h: Vector, a: Vector, b: Vector, rest: Turn = NO_TURN) -> tuple[Turn, Truth]:
    """The turn about h that brings a upon b as seen along h (subproblem 1), and whether every turn does.

    Both are equally far from h, hence the square. (h x a) . (h x b) keeps its digits where both are nearly along h.
    """
    quarter = cross(h, a)
    return unit(dot(quarter, cross(h, b)), dot(quarter, b), rest, FREE * FREE)


def turns_to_level(
    h: Vector,
    a: Vector,
    b: Vector,
    d: Number,
    rest: Turn = NO_TURN,
    *,
    sine_square: Number | None = None,
) -> tuple[list[Turn], Truth]:
    """Both turns about h with b . R(h, turn) a = d (subproblem 4), and whether all are equal to it.

    A cos + B sin = D has the solutions atan2(B, A) +- acos(D / |A, B|), the plus first. Out of reach both are the turn
    that comes nearest. `sine_square` is A^2 + B^2 - D^2 where the caller knows it without cancellation.
    """
    quarter = cross(h, a)
    A, B, D = dot(quarter, cross(h, b)), dot(quarter, b), d - dot(h, a) * dot(h, b)
    middle, free = unit(A, B, rest)
    square = A * A + B * B - D * D if sine_square is None else sine_square
    half, _ = unit(D, sqrt(maximum(square, 0.0)))
    return [followed_by(middle, half), followed_by(middle, reverse(half))], free


def two_parallel_turns(first: Screw, second: Screw, c: Vector, w: Vector) -> list[Branch]:
    """Both ways of two parallel joints to bring the point c to w; the second joint's larger angle first.

    Their points must lie in one plane across the axes; c and w in another one.
    """
    e, f, u = sub(second.p, first.p), sub(c, second.p), sub(w, first.p)
    reach = 0.5 * (dot(u, u) - dot(e, e) - dot(f, f))
    turns, free = turns_to_level(second.h, f, e, reach, second.rest)
    branches = []
    for turn in turns:
        onto, loose = turn_onto(first.h, add(e, rotated(second.h, turn, f)), u, first.rest)
        branches.append(Branch([onto, turn], free | loose))
    return branches
