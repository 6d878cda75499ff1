"""Inverse and forward model of a whole base, and the angles of its steered wheels; traced, or on floats.

A base comes as a `Layout`. `axles` hold the sine and cosine of alpha + beta of every wheel: constants, or from the
steering angles, or, without any trigonometry, from the twist itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from holonom.mobile.equations.wheels import Row, rolling_row, sliding_row
from holonom.mobile.wheel import KINDS, Wheel
from holonom.trace import Number, absolute, atan2, cos, less, maximum, select, sin, sqrt

__all__ = [
    "Axle", "Layout", "axles_at", "drag", "free_wheel_speeds", "rolling_rows", "sliding_rows", "steering_angles",
    "twist_of_speeds", "wheel_speeds",
]  # fmt: skip

Axle = tuple[Number, Number]
STANDSTILL = 1e-9
"""Speed of a contact point, m/s, below which its wheel is left as it stands."""


class Layout(NamedTuple):
    """Wheels, and the groups of steered wheels that turn together (indices into `wheels`); `radius` scales w."""

    wheels: tuple[Wheel, ...]
    groups: tuple[tuple[int, ...], ...]
    radius: float

    def axles(self, turned: Sequence[Axle]) -> list[Axle]:
        """Sine and cosine of alpha + beta of every wheel, of those in groups from sine and cosine of the angle."""
        axles: list[Axle] = [(math.sin(w.axle), math.cos(w.axle)) for w in self.wheels]
        for members, (sd, cd) in zip(self.groups, turned, strict=True):
            for i in members:
                s, c = axles[i]
                axles[i] = (s * cd + c * sd, c * cd - s * sd)
        return axles


def axles_at(layout: Layout, steering: Sequence[Number]) -> list[Axle]:
    """The axles at steering angles, one angle per group."""
    return layout.axles([(sin(angle), cos(angle)) for angle in steering])


def rolling_rows(layout: Layout, axles: Sequence[Axle], *, driven: bool = True) -> list[tuple[Wheel, Row]]:
    """Rolling rows of the driven wheels, or of all, each with its wheel."""
    chosen = [(w, a) for w, a in zip(layout.wheels, axles, strict=True) if w.driven or not driven]
    return [(w, row) for w, (s, c) in chosen for row in KINDS[w.kind].rolling(w, s, c)]


def sliding_rows(layout: Layout, axles: Sequence[Axle]) -> list[tuple[Wheel, Row]]:
    """Rows of all wheels that must not slide sideways, each with its wheel."""
    pairs = zip(layout.wheels, axles, strict=True)
    return [(w, row) for w, (s, c) in pairs for row in KINDS[w.kind].sliding(w, s, c)]


def wheel_speeds(layout: Layout, twist: Row, axles: Sequence[Axle]) -> Row:
    """Inverse model: rad/s of the driven speeds."""
    return [_dot(row, twist) / w.radius for w, row in rolling_rows(layout, axles)]


def drag(layout: Layout, twist: Row, axles: Sequence[Axle]) -> Number:
    """Largest sideways speed of a wheel that must not slide, m/s."""
    worst: Number = 0.0
    for _, row in sliding_rows(layout, axles):
        worst = maximum(worst, absolute(_dot(row, twist)))
    return worst


def free_wheel_speeds(layout: Layout, twist: Row) -> tuple[Row, Number]:
    """Inverse model with every group steered as `steering_angles` steers it, and the drag that this leaves.

    Wheels that steer alone never drag; their rows are left out of the drag.
    """
    axles = layout.axles([_course(layout, members, twist, None)[1] for members in layout.groups])
    alone = {g[0] for g in layout.groups if len(g) == 1}
    rest = [i for i in range(len(layout.wheels)) if i not in alone]
    held = Layout(tuple(layout.wheels[i] for i in rest), (), layout.radius)
    return wheel_speeds(layout, twist, axles), drag(held, twist, [axles[i] for i in rest])


def steering_angles(layout: Layout, twist: Row, current: Sequence[Number] | None) -> Row:
    """Angle of each group, every axle through the centre of rotation; see `WheelBase.steering`."""
    now: Sequence[Number | None] = current if current is not None else [None] * len(layout.groups)
    return [_course(layout, m, twist, c)[0] for m, c in zip(layout.groups, now, strict=True)]


def _course(
    layout: Layout, members: Sequence[int], twist: Row, current: Number | None
) -> tuple[Number, Axle]:  # fmt: skip
    """Angle of a group and its sine and cosine: along p, across q of each contact's velocity, turned with the wheel."""
    start: Axle = (sin(current), cos(current)) if current is not None else (0.0, 1.0)
    along, across = _seen_from(layout, members, twist, start)
    limited = any(layout.wheels[i].max_steering is not None for i in members)
    if len(members) > 1:
        along, across = _common(along, across, flip=current is None and not limited)
    p, q = along[0], across[0]
    if current is not None or limited:  # the half turn that is nearest
        back = less(p, 0.0)
        p, q = select(back, -p, p), select(back, -q, q)
    square = p * p + q * q
    moving = less(STANDSTILL * STANDSTILL, square)
    p, q, speed = select(moving, p, 1.0), select(moving, q, 0.0), sqrt(select(moving, square, 1.0))
    s, c = q / speed, p / speed
    angle = atan2(q, p)
    return (angle if current is None else current + angle), (s * start[1] + c * start[0], c * start[1] - s * start[0])


def _seen_from(
    layout: Layout, members: Sequence[int], twist: Row, turned: Axle
) -> tuple[Row, Row]:  # fmt: skip
    """Speeds of the members' contact points along and across their wheels, the group turned by an angle."""
    axles = Layout(tuple(layout.wheels[i] for i in members), (tuple(range(len(members))),), 1.0).axles([turned])
    along, across = [], []
    for i, (s, c) in zip(members, axles, strict=True):
        wheel = layout.wheels[i]
        along.append(_dot(rolling_row(wheel.x, wheel.y, s, c), twist))
        across.append(_dot(sliding_row(wheel.x, wheel.y, s, c), twist))
    return along, across


def _common(along: Row, across: Row, *, flip: bool) -> tuple[Row, Row]:
    """One direction for all members: the one that drags them least, sum of (across cos - along sin)^2 smallest."""
    cos2, sin2 = _sum([p * p - q * q for p, q in zip(along, across, strict=True)]), 2.0 * _dot(along, across)
    half = 0.5 * atan2(sin2, cos2)
    s, c = sin(half), cos(half)
    forwards = _sum([p * c + q * s for p, q in zip(along, across, strict=True)])
    size = sqrt(_sum([p * p + q * q for p, q in zip(along, across, strict=True)]))
    turn: Number = select(less(forwards, 0.0), -size, size) if flip else size
    return [turn * c], [turn * s]


def twist_of_speeds(layout: Layout, speeds: Row, axles: Sequence[Axle]) -> tuple[Row, Number]:
    """Forward model: the twist that fits rolling and sliding rows best (least squares in m/s, w scaled by the radius).

    Also how well it is determined: determinant of the normal matrix over the cube of a third of its usual trace.
    """
    normal: list[Row] = [[0.0, 0.0, 0.0] for _ in range(3)]
    right: Row = [0.0, 0.0, 0.0]
    scale = (1.0, 1.0, 1.0 / layout.radius)
    values = iter(speeds)
    for wheel, axle in zip(layout.wheels, axles, strict=True):
        kind = KINDS[wheel.kind]
        rolling = [_times(row, scale) for row in (kind.rolling(wheel, *axle) if wheel.driven else [])]
        for row in rolling:
            rim = next(values) * wheel.radius
            right = [b + a * rim for a, b in zip(row, right, strict=True)]
        rows = rolling + [_times(row, scale) for row in kind.sliding(wheel, *axle)]
        for row in _upright(wheel, scale) if _both(wheel) else rows:
            normal = [[n + row[i] * row[j] for j, n in enumerate(line)] for i, line in enumerate(normal)]
    solution, determinant = _solve(normal, right)
    return _times(solution, scale), determinant * _usual_trace(layout) ** -3


def _usual_trace(layout: Layout) -> float:
    """A third of the trace of the normal matrix if each row is a unit vector with a moment of l / radius."""
    rows = [
        (w, len(KINDS[w.kind].rolling(w, 0.0, 1.0)) * w.driven + len(KINDS[w.kind].sliding(w, 0.0, 1.0)))
        for w in layout.wheels
    ]
    return sum(n * (1.0 + (w.l / layout.radius) ** 2) for w, n in rows) / 3.0


def _both(wheel: Wheel) -> bool:
    """Whether the wheel fixes both components of its contact's velocity: then its share does not hang on its angle."""
    return wheel.driven and wheel.kind in ("fixed", "steered")


def _upright(wheel: Wheel, scale: Sequence[float]) -> list[Row]:
    rows = [rolling_row(wheel.x, wheel.y, 1.0, 0.0), sliding_row(wheel.x, wheel.y, 1.0, 0.0)]
    return [_times(row, scale) for row in rows]


def _solve(A: Sequence[Row], b: Row) -> tuple[Row, Number]:
    """Solution of A x = b by cofactors, A symmetric (3, 3), and the determinant (1.0 where that is 0)."""
    c00 = A[1][1] * A[2][2] - A[1][2] * A[1][2]
    c01 = A[0][2] * A[1][2] - A[0][1] * A[2][2]
    c02 = A[0][1] * A[1][2] - A[0][2] * A[1][1]
    c11 = A[0][0] * A[2][2] - A[0][2] * A[0][2]
    c12 = A[0][1] * A[0][2] - A[0][0] * A[1][2]
    c22 = A[0][0] * A[1][1] - A[0][1] * A[0][1]
    determinant = A[0][0] * c00 + A[0][1] * c01 + A[0][2] * c02
    inverse = 1.0 / select(less(absolute(determinant), 1e-300), 1.0, determinant)
    cofactors = ([c00, c01, c02], [c01, c11, c12], [c02, c12, c22])
    return [_dot(row, b) * inverse for row in cofactors], determinant


def _dot(a: Row, b: Row) -> Number:
    return _sum([p * q for p, q in zip(a, b, strict=True)])


def _sum(terms: Sequence[Number]) -> Number:
    total: Number = 0.0
    for term in terms:
        total = total + term
    return total


def _times(row: Row, scale: Sequence[float]) -> Row:
    return [a * k for a, k in zip(row, scale, strict=True)]
