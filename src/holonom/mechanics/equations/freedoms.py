"""What the equations of motion need of a joint's one freedom: a line of the table for each kind that has one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from holonom.mechanics.equations.vectors import Vector, cross, scale
from holonom.trace import Number, cos, sin

__all__ = ["FREEDOMS", "Freedom"]

NOTHING: Vector = (0.0, 0.0, 0.0)


class Freedom(NamedTuple):
    """How a joint moves about or along its axis z; all vectors in one frame.

    Attributes
    ----------
    displaced
        q -> the rotation about z and the way along it.
    twist
        z, r -> angular velocity, and velocity of the point that lies at r from the axis, of a unit rate.
    spin
        z, qd, qdd, w -> what it adds to the carrier's angular velocity w and to its rate.
    drift
        z, qd, qdd, w -> what it adds to the acceleration of a point that it carries, w being the carrier's.
    force
        f, m -> what a force and a moment about the axis' point do along the freedom, as a vector to take the part
        along z of.
    """

    displaced: Callable[[Number], tuple[list[list[Number]] | None, Number]]
    twist: Callable[[Vector, Vector], tuple[Vector, Vector]]
    spin: Callable[[Vector, Number, Number, Vector], tuple[Vector, Vector]]
    drift: Callable[[Vector, Number, Number, Vector], Vector]
    force: Callable[[Vector, Vector], Vector]


def _turned(q: Number) -> tuple[list[list[Number]], Number]:
    c, s = cos(q), sin(q)
    return [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], 0.0


def _spin(z: Vector, qd: Number, qdd: Number, w: Vector) -> tuple[Vector, Vector]:
    about = scale(qd, z)
    return about, [a + b for a, b in zip(scale(qdd, z), cross(w, about), strict=True)]


def _drift(z: Vector, qd: Number, qdd: Number, w: Vector) -> Vector:
    """The way's own acceleration and Coriolis'."""
    return [a + b for a, b in zip(scale(qdd, z), scale(2.0, cross(w, scale(qd, z))), strict=True)]


FREEDOMS: Mapping[str, Freedom] = {
    "revolute": Freedom(
        displaced=_turned,
        twist=lambda z, r: (z, cross(z, r)),
        spin=_spin,
        drift=lambda z, qd, qdd, w: NOTHING,
        force=lambda f, m: m,
    ),
    "prismatic": Freedom(
        displaced=lambda q: (None, q),
        twist=lambda z, r: (NOTHING, z),
        spin=lambda z, qd, qdd, w: (NOTHING, NOTHING),
        drift=_drift,
        force=lambda f, m: f,
    ),
}
