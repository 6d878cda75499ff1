"""Angles of steered wheels that put their axles through the centre of rotation, and the inverse model at those.

Nothing but the angle itself takes trigonometry: a group's direction stays a vector (along, across), from the wheels at
rest, until its `atan2`, and a wheel that steers alone runs at the speed of its contact point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from holonom.mobile.equations.base_models import Axle, Layout, drag, speed_along, wheel_speeds
from holonom.mobile.equations.wheels import Row, rolling_row, sliding_row, summed, unit
from holonom.trace import Condition, Number, absolute, atan2, less, select, sqrt

__all__ = ["free_wheel_speeds", "steering_angles"]

STANDSTILL = 1e-9
"""Speed of a contact point, m/s, below which its wheel is left as it stands."""
SHIFT = 1.5 * 2.0**52
"""A double of this size has no fraction: adding and subtracting it rounds to the nearest whole number."""


class Course(NamedTuple):
    """Direction (p, q) of a group along and across its wheels at rest, any length; `moving` whether it counts."""

    p: Number
    q: Number
    moving: Condition | bool


def steering_angles(layout: Layout, twist: Row, current: Sequence[Number] | None) -> Row:
    """Angle of each group, every axle through the centre of rotation, castors as they are; `WheelBase.steering`."""
    if current is None:
        return [
            0.0 if _swings(layout, members) else _angle(_course(layout, members, twist)) for members in layout.groups
        ]
    pairs = zip(layout.groups, current, strict=True)
    return [now if _swings(layout, m) else _angle_near(layout, m, twist, now) for m, now in pairs]


def free_wheel_speeds(layout: Layout, twist: Row) -> tuple[Row, Number]:
    """Inverse model with every group steered as `steering_angles` steers it, and the drag that this leaves.

    Wheels that steer alone never drag; driven castors are at rest.
    """
    alone = {g[0] for g in layout.groups if len(g) == 1 and layout.wheels[g[0]].kind != "castor"}
    turned = [(0.0, 1.0) if len(g) == 1 else _unit(_course(layout, g, twist)) for g in layout.groups]
    axles = layout.axles(turned)
    speeds: Row = []
    for i, (wheel, axle) in enumerate(zip(layout.wheels, axles, strict=True)):
        one = Layout((wheel,), (), layout.radius)
        speeds += [_alone(layout, i, twist)] if i in alone and wheel.driven else wheel_speeds(one, twist, [axle])
    rest = [i for i in range(len(layout.wheels)) if i not in alone]
    held = Layout(tuple(layout.wheels[i] for i in rest), (), layout.radius)
    return speeds, drag(held, twist, [axles[i] for i in rest])


def _angle(course: Course) -> Number:
    return atan2(select(course.moving, course.q, 0.0), select(course.moving, course.p, 1.0))


def _angle_near(layout: Layout, members: Sequence[int], twist: Row, now: Number) -> Number:
    """The angle that is nearest to `now` modulo half turns; of a limited group the one around its rest."""
    p, q, moving = _course(layout, members, twist)
    angle = atan2(q, p)
    if not _limited(layout, members):
        half_turns = ((now - angle) * (1.0 / math.pi) + SHIFT) - SHIFT
        angle = angle + half_turns * math.pi
    return select(moving, angle, now)


def _alone(layout: Layout, i: int, twist: Row) -> Number:
    """Speed of a driven wheel that steers alone, rad/s: that of its contact point."""
    p, q, moving = _course(layout, [i], twist)
    speed = sqrt(p * p + q * q)
    if _limited(layout, [i]):
        along, _ = _seen(layout, [i], twist)
        speed = select(less(along[0], 0.0), -speed, speed)
    return select(moving, speed, p) / layout.wheels[i].radius


def _unit(course: Course) -> Axle:
    """Sine and cosine of the course's angle; those of 0 at a standstill."""
    length = sqrt(course.p * course.p + course.q * course.q)
    good = course.moving & less(0.0, length)
    inverse = 1.0 / select(good, length, 1.0)
    return select(good, course.q, 0.0) * inverse, select(good, course.p, 1.0) * inverse


def _course(layout: Layout, members: Sequence[int], twist: Row) -> Course:
    """Direction of a group: along, across of its contact's velocity; of several, the one that drags them least."""
    along, across = _seen(layout, members, twist)
    square = summed([p * p + q * q for p, q in zip(along, across, strict=True)])
    p, q = (along[0], across[0]) if len(members) == 1 else _common(along, across)
    if _limited(layout, members):  # the half turn around the rest
        p, q = absolute(p), select(less(p, 0.0), -q, q)
    return Course(p, q, less(STANDSTILL * STANDSTILL, square))


def _swings(layout: Layout, members: Sequence[int]) -> bool:
    """Whether it is a driven castor, which may stand at any angle."""
    return layout.wheels[members[0]].kind == "castor"


def _limited(layout: Layout, members: Sequence[int]) -> bool:
    return any(layout.wheels[i].max_steering is not None for i in members)


def _seen(layout: Layout, members: Sequence[int], twist: Row) -> tuple[Row, Row]:
    """Speeds of the members' contact points along and across their wheels at rest."""
    along, across = [], []
    for wheel in (layout.wheels[i] for i in members):
        s, c = unit(wheel.axle)
        along.append(speed_along(wheel, rolling_row(wheel.x, wheel.y, s, c), twist))
        across.append(speed_along(wheel, sliding_row(wheel.x, wheel.y, s, c), twist))
    return along, across


def _common(along: Row, across: Row) -> tuple[Number, Number]:
    """One direction for all members, forwards: where sum of (across cos - along sin)^2 is smallest.

    That is at half the angle of (C, S), C = sum of along^2 - across^2, S = 2 sum of along across: along (r + C, S), or,
    where this vanishes, along (|S|, r - C) with the sign of S, r = |(C, S)|.
    """
    C = summed([p * p - q * q for p, q in zip(along, across, strict=True)])
    S = 2.0 * summed([p * q for p, q in zip(along, across, strict=True)])
    r, ahead, left = sqrt(C * C + S * S), less(0.0, C), less(S, 0.0)
    p, q = select(ahead, r + C, absolute(S)), select(ahead, S, select(left, C - r, r - C))
    backwards = less(summed(along) * p + summed(across) * q, 0.0)
    return select(backwards, -p, p), select(backwards, -q, q)
