"""What a set of wheels allows: mobility, steerability, manoeuvrability (Campion, Bastin & d'Andrea-Novel 1996)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError
from holonom.mobile.base.centre import axle_miss
from holonom.mobile.base.protocol import ConstrainedBase
from holonom.mobile.base.wheel import KINDS
from holonom.mobile.equations.base_models import Axle, Layout, axles_at, sliding_rows
from holonom.mobile.equations.steering import steering_angles

__all__ = [
    "Mobility", "Stance", "check_movable", "conflicting_wheels", "degrees_of_freedom", "is_holonomic", "mobility",
    "stance",
]  # fmt: skip

RANK = 1e-7
"""Singular value of the sliding rows (w scaled by the base's radius) below which they leave a motion free."""


FIRST_ANGLES = (0.37, 1.03, 1.91, 2.73)
"""Steering angles whose motions together span those of all: any will do, but no special ones."""


MOST = 3  # wheels that are in each other's way, of which it is said what is left without them


class Mobility(NamedTuple):
    """Degrees of mobility dm, of steerability ds and of manoeuvrability dM = dm + ds."""

    dm: int
    ds: int
    dM: int


class Stance(NamedTuple):
    """Steering at which a set of wheels can move, its motions, and how many groups chose their angle freely."""

    steering: tuple[float, ...]
    motions: Array
    independent: int


def mobility(base: ConstrainedBase) -> Mobility:
    """Mobility, steerability and manoeuvrability of a base.

    `dm` is 3 minus the rank of the sliding constraints at a steering that lets the base move; `ds` is how many steered
    groups may be set independently before the others have to follow (Siegwart & Nourbakhsh 3.3: at most
    2 - rank C1f). Differential drive (2, 0, 2), omnidirectional and driven castors (3, 0, 3), car (1, 1, 2), swerve
    (1, 2, 3).
    """
    found = stance(base.layout)
    assert found is not None, "a WheelBase can move"
    dm = found.motions.shape[1]
    return Mobility(dm, found.independent, dm + found.independent)


def degrees_of_freedom(base: ConstrainedBase) -> int:
    """Dimension of the poses that the base can reach by rolling and steering (DOF, Siegwart & Nourbakhsh 3.4).

    Reached is what all twists that some steering allows, and their Lie brackets, span: a differential drive parks
    sideways, so it has 3; synchro drive never turns, so it has 2; four fixed wheels that only roll straight have 1.
    """
    scale = np.array([[1.0], [1.0], [base.radius]])
    found = [stance(base.layout, first) for first in FIRST_ANGLES]
    reached = _span(scale * np.hstack([s.motions for s in found if s is not None]))
    while True:
        twists = (reached / scale).T
        brackets = [_bracket(a, b) for a, b in itertools.combinations(twists, 2)]
        more = _span(np.column_stack([reached, *(scale[:, 0] * b for b in brackets)]))
        if more.shape[1] == reached.shape[1]:
            return int(more.shape[1])
        reached = more


def is_holonomic(base: ConstrainedBase) -> bool:
    """Whether the sliding constraints are integrable: they hold poses back, or nothing, but not velocities alone.

    So it is where the base reaches no more than it can move at once, `degrees_of_freedom` = dm (Siegwart & Nourbakhsh
    3.4: DOF = DDOF). Omnidirectional bases are, and so are wheels that leave one motion, such as fixed wheels on two
    crossing axles, which only turn about one point. Differential drives, cars, synchro and swerve drives are not.
    Whether it moves every way at once is another question: `mobility(base).dm == 3`.
    """
    return degrees_of_freedom(base) == mobility(base).dm


def _bracket(a: Array, b: Array) -> Array:
    """Lie bracket of two twists of the plane: (wa J vb - wb J va, 0), J a quarter turn."""
    return np.array([b[2] * a[1] - a[2] * b[1], a[2] * b[0] - b[2] * a[0], 0.0])


def _span(columns: Array) -> Array:
    """Orthonormal basis (3, k) of the span of columns (3, n)."""
    U, s, _ = np.linalg.svd(columns / max(np.abs(columns).max(initial=0.0), 1e-300))
    basis: Array = U[:, : np.count_nonzero(s > RANK)]
    return basis


def conflicting_wheels(layout: Layout) -> tuple[int, ...]:
    """A smallest set of wheels that cannot roll together: without any one of them the others could; () if all can."""
    if stance(layout) is not None:
        return ()
    kept = [i for i, w in enumerate(layout.wheels) if KINDS[w.kind].sliding(w, 0.0, 1.0)]
    for i in tuple(kept):
        fewer = [k for k in kept if k != i]
        if stance(_part(layout, fewer)) is None:
            kept = fewer
    return tuple(kept)


def check_movable(layout: Layout) -> None:
    """Refuse wheels that cannot roll together.

    Raises
    ------
    ModelError
        Names a smallest set of wheels whose axles miss each other, and by how much.
    """
    held = conflicting_wheels(layout)
    if not held:
        return
    part = _part(layout, held)
    names = ", ".join(repr(w.name) for w in part.wheels)
    miss = axle_miss(layout.radius, _rows(part, tuple(0.0 for _ in part.groups)))
    raise ModelError(
        f"wheels {names} cannot roll together: their axles meet in no common point at any steering "
        f"(at rest they miss by {miss:.3g} m), so the base cannot move{_left(layout, held)}; turn an axle to the "
        "point where the others meet, steer one of them by itself, or make one a castor"
    )


def _left(layout: Layout, held: Sequence[int]) -> str:
    """What motion the base has without one of the wheels that are in each other's way, for the first few of these."""
    found = []
    for i in held[:MOST]:
        rest = stance(_part(layout, [k for k in range(len(layout.wheels)) if k != i]))
        if rest is not None:
            found.append(f"without {layout.wheels[i].name!r} it could {_motion(layout.radius, rest.motions)}")
    return "".join(f"; {text}" for text in found)


def _motion(radius: float, motions: Array) -> str:
    """Motions (3, dm) in words."""
    if motions.shape[1] > 1:
        return f"move in {motions.shape[1]} ways at once"
    vx, vy, w = motions[:, 0]
    if abs(w) * radius < RANK * math.hypot(vx, vy):
        return f"only move straight on, at {math.degrees(math.atan2(vy, vx)) % 180.0:.3g} deg"
    x, y = round(-vy / w, 9) + 0.0, round(vx / w, 9) + 0.0  # no -0
    return f"only turn about ({x:.3g}, {y:.3g}) m"


def stance(layout: Layout, first: float = 0.37) -> Stance | None:
    """A generic steering at which the base can move, another for another angle of its first group; None if none.

    Groups are set one after the other: at any angle while that leaves a motion, else at the angle that this motion
    asks for, else (a group that only fits straight ahead) at zero, which then goes first.
    """
    groups = range(len(layout.groups))
    for count in range(len(layout.groups) + 1):
        for stuck in itertools.combinations(groups, count):
            found = _settle(layout, stuck, first)
            if found is not None:
                return found
        if all(len(g) == 1 for g in layout.groups):
            break  # a wheel that steers alone follows any motion
    return None


def _settle(layout: Layout, stuck: Sequence[int], first: float) -> Stance | None:
    steering = [0.0] * len(layout.groups)
    steered = {i for g in layout.groups for i in g}
    held = [i for i in range(len(layout.wheels)) if i not in steered]
    held += [i for k in stuck for i in layout.groups[k]]
    motions, independent = _motions(layout, held, steering), 0
    for k in range(len(layout.groups)):
        if motions.shape[1] == 0:
            return None
        if k in stuck:
            continue
        held += layout.groups[k]
        steering[k] = first + 0.61 * k  # any angle will do, but no special one
        left = _motions(layout, held, steering)
        if left.shape[1]:
            independent += _holds(layout, k)
        else:
            motion = motions @ np.cos(1.0 + np.arange(motions.shape[1]))
            steering[k] = float(steering_angles(layout, [float(v) for v in motion], None)[k])
            left = _motions(layout, held, steering)
        motions = left
    return Stance(tuple(steering), motions, independent) if motions.shape[1] else None


def _holds(layout: Layout, group: int) -> bool:
    """Whether wheels of a group must not slide sideways: a driven castor may be at any angle, which steers nothing."""
    return any(layout.wheels[i].kind != "castor" for i in layout.groups[group])


def _motions(layout: Layout, held: Sequence[int], steering: Sequence[float]) -> Array:
    """Twists (3, dm) that drag none of the wheels `held`."""
    axles = axles_at(layout, steering)
    chosen = Layout(tuple(layout.wheels[i] for i in held), (), layout.radius)
    return free_twists(layout.radius, _matrix(chosen, [axles[i] for i in held]))


def seen_twists(radius: float, C1: Array) -> Array:
    """Row space (..., 3, 3) of sliding rows (..., n, 3): orthonormal rows in (vx, vy, R w), zero beyond the rank."""
    _, s, Vt = np.linalg.svd(_scaled(radius, C1))
    basis: Array = np.where(s[..., None] > RANK, Vt[..., :3, :], 0.0)
    return basis


def free_twists(radius: float, C1: Array) -> Array:
    """Null space (3, dm) of sliding rows (n, 3): twists, orthonormal in (vx, vy, R w)."""
    _, s, Vt = np.linalg.svd(_scaled(radius, C1))
    return np.array([[1.0], [1.0], [1.0 / radius]]) * Vt[np.count_nonzero(s > RANK) :].T


def _scaled(radius: float, C1: Array) -> Array:
    """Rows for (vx, vy, R w), with rows of zeros so that there are three singular values."""
    rows = C1 * np.array([1.0, 1.0, 1.0 / radius])
    return np.concatenate([rows, np.zeros((*rows.shape[:-2], 3, 3))], axis=-2)


def _rows(layout: Layout, steering: Sequence[float]) -> Array:
    return _matrix(layout, axles_at(layout, steering))


def _matrix(layout: Layout, axles: Sequence[Axle]) -> Array:
    return np.array([row for _, row in sliding_rows(layout, axles)], dtype=float).reshape(-1, 3)


def _part(layout: Layout, kept: Sequence[int]) -> Layout:
    """The layout of some of the wheels; groups keep what members are left."""
    place = {i: k for k, i in enumerate(kept)}
    groups = [tuple(place[i] for i in g if i in place) for g in layout.groups]
    return Layout(tuple(layout.wheels[i] for i in kept), tuple(g for g in groups if g), layout.radius)
