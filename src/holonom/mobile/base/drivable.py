"""Twists that wheels with limited steering can follow: the nearest one, and the tightest curve.

A wheel that turns by up to d to either side of its rest follows a contact velocity of p along and q across that rest if
|q| <= tan(d) |p|: two opposite wedges. Of a base they make a union of polyhedral cones; the nearest point of one is the
foot of a perpendicular on the span of one of its faces, so all spans are tried (Nocedal & Wright, Numerical
Optimization, 16.5: active sets, here few enough to list).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import ModelError
from holonom.mobile.base.dynamics import free_motions
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.equations.base_models import Layout
from holonom.mobile.equations.wheels import rolling_row, sliding_row, unit

__all__ = ["Wedges", "check_steerable", "moves_sideways", "skids", "tightest_curve", "wedges_of"]

ROUNDING = 1e-9
"""Of a twist, by which it may lie outside a wedge; part of a radian by which it is kept inside."""


SMALL = 1e-12  # of a matrix's entries


class Wedges:
    """The limits of a base's steered wheels, in (vx, vy, R w).

    Parameters
    ----------
    wheels
        With their limits, rad; those that turn all around have none.
    held
        (n, 3) sliding rows per (vx, vy, R w) of wheels that do not steer.
    radius
        R, m.
    """

    def __init__(self, wheels: list[tuple[Wheel, float]], held: Array, radius: float) -> None:
        self.held, self.radius, scale = held, radius, np.array([1.0, 1.0, 1.0 / radius])
        bound = [(wheel, limit) for wheel, limit in wheels if limit < 0.5 * math.pi - ROUNDING]
        self.bound = bound
        self.slope = np.array([math.tan(limit) * (1.0 - ROUNDING) for _, limit in bound])
        places = [(wheel.x, wheel.y, *unit(wheel.axle)) for wheel, _ in bound]
        self.along = np.array([rolling_row(*place) for place in places], dtype=float).reshape(-1, 3) * scale
        self.across = np.array([sliding_row(*place) for place in places], dtype=float).reshape(-1, 3) * scale

    def of(self, kept: Sequence[int]) -> Wedges:
        """The wedges of some of the wheels that have limits."""
        return Wedges([self.bound[k] for k in kept], self.held, self.radius)

    @property
    def projector(self) -> Array:
        """(3, 3): a twist (vx, vy, w) to the nearest one that drags no fixed wheel."""
        free, scale = free_motions(self.held), np.array([1.0, 1.0, self.radius])
        found: Array = (free @ free.T) * scale / scale[:, None]
        return np.where(np.abs(found) < SMALL, 0.0, found)

    @property
    def edges(self) -> Array:
        """(2 m, 3) rows that vanish on the edges of the wedges."""
        lean = self.slope[:, None] * self.along
        return np.concatenate([lean - self.across, lean + self.across])

    def hold(self, v: Array) -> Array:
        """Whether twists (..., 3) lie in all wedges, (...)."""
        size = ROUNDING * (np.linalg.norm(v, axis=-1, keepdims=True) + 1e-300)
        inside = np.abs(v @ self.across.T) <= self.slope * np.abs(v @ self.along.T) + size
        return np.asarray(inside.all(axis=-1))

    def nearest(self, v: Array) -> Array:
        """The nearest twists (N, 3) that drag no fixed wheel and lie in all wedges."""
        free = free_motions(self.held)
        v = v @ free @ free.T
        beyond = np.flatnonzero(np.logical_not(self.hold(v)))
        if not len(beyond):
            return v
        asked, best = v[beyond], np.zeros((len(beyond), 3))
        least = np.linalg.norm(asked, axis=1)  # a base that stands is inside
        for rows in _subsets(self.edges, free.shape[1]):
            span = free_motions(np.concatenate([self.held, rows]))
            foot = asked @ span @ span.T
            far = np.linalg.norm(asked - foot, axis=1)
            nearer = (far < least) & self.hold(foot)
            best[nearer], least[nearer] = foot[nearer], far[nearer]
        found = v.copy()
        found[beyond] = best
        return found


def check_steerable(name: str, wedges: Wedges) -> None:
    """Refuse limits of steered wheels within which no twist lies at all.

    Raises
    ------
    ModelError
        Names a smallest set of wheels whose limits exclude each other.
    """
    if _movable(wedges):
        return
    kept = list(range(len(wedges.bound)))
    for k in tuple(kept):
        fewer = [i for i in kept if i != k]
        if not _movable(wedges.of(fewer)):
            kept = fewer
    limits = ", ".join(f"{w.name!r} ({math.degrees(limit):.3g} deg)" for w, limit in (wedges.bound[k] for k in kept))
    fixed = " and what the fixed wheels allow" if len(wedges.held) else ""
    raise ModelError(
        f"base {name!r} cannot move: the steering limits of {limits}{fixed} exclude each other, no motion is within "
        "all of them; give more max_steering, or turn the wheels at rest to where they are to roll"
    )


def _movable(wedges: Wedges) -> bool:
    """Whether any twist but rest lies in all wedges: then one on their edges does, or one that has no edge."""
    if not len(wedges.bound):
        return True
    for rows in _subsets(wedges.edges, free_motions(wedges.held).shape[1]):
        span = free_motions(np.concatenate([wedges.held, rows]))
        if span.shape[1] and wedges.hold(span.T).any():
            return True
    return False


def wedges_of(layout: Layout, limits: Sequence[float], names: Sequence[str], sliding: Array, radius: float) -> Wedges:
    """The wedges of a base: limits of its steering angles, and its sliding rows (s, 3) with their wheels' names."""
    limited = [(layout.wheels[i], limit) for group, limit in zip(layout.groups, limits, strict=True) for i in group]
    steered = {layout.wheels[i].name for group in layout.groups for i in group}
    held = sliding[[name not in steered for name in names]] * np.array([1.0, 1.0, 1.0 / radius])
    return Wedges(limited, _together(layout, held), radius)


def _together(layout: Layout, held: Array) -> Array:
    """The sliding rows of fixed wheels, and that a base whose wheels all steer as one does not turn."""
    shared = [group for group in layout.groups if len(group) > 1]
    lone = any(len(group) == 1 for group in layout.groups)
    apart = [len({(layout.wheels[i].x, layout.wheels[i].y) for i in group}) > 1 for group in shared]
    never = np.array([[0.0, 0.0, 1.0]]) if any(apart) and not lone and not len(held) else np.empty((0, 3))
    return np.concatenate([held, never])


def tightest_curve(wedges: Wedges, radius: float) -> float:
    """Radius, m, of the tightest curve that base_link can drive to the left as well as to the right.

    0 where it turns on the spot, infinite where it cannot turn.
    """
    found = [math.inf, math.inf]
    ahead = np.array([[1.0, 0.0, 0.0]])
    for rows in _subsets(np.concatenate([wedges.edges, ahead]), 3):
        A = np.concatenate([wedges.held, rows, [[0.0, 0.0, 1.0 / radius]]])
        b = np.append(np.zeros(len(A) - 1), 1.0)
        v = np.linalg.lstsq(np.concatenate([A, 1e-9 * np.eye(2, 3)]), np.append(b, [0.0, 0.0]), rcond=None)[0]
        if np.abs(A @ v - b).max() > 1e-6 or not wedges.hold(v):
            continue
        size = math.hypot(v[0], v[1])
        for side, to in enumerate((v[0], -v[0])):
            if to >= -1e-6 * size:
                found[side] = min(found[side], size)
    return 0.0 if max(found) < 1e-6 else max(found)


def _subsets(rows: Array, most: int) -> list[Array]:
    """Sets of up to so many rows less one: spans of at least one dimension."""
    return [rows[list(k)] for n in range(most) for k in itertools.combinations(range(len(rows)), n)]


def skids(wheels: Sequence[Wheel]) -> bool:
    """Whether a base turns as its wheels slip across."""
    return any(wheel.kind == "skid" for wheel in wheels)


class _Drivable(Protocol):
    def feasible(self, twist: ArrayLike) -> Array: ...


def moves_sideways(base: _Drivable) -> bool:
    """Whether a base can move along y at once, wherever it looks."""
    aside = np.array([0.0, 1.0, 0.0])
    return bool(np.abs(base.feasible(aside) - aside).max() < 1e-6)
