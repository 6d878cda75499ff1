"""Reference paths from pose to pose, of arcs and straights, for bases that cannot turn on the spot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import vectors
from holonom.errors import InputError, ShapeError
from holonom.machine.base.paths.timing import GRID, TICK, PathLimits, ReferencePath, in_time, squared_speeds
from holonom.mobile.curves.curve import TURNS, Curves, turned_poses
from holonom.registry import parameter

__all__ = ["Poses", "joined", "plan_segments"]

_ROUNDING = 1e-9  # m/s, of a speed that is none


@dataclass(frozen=True, slots=True)
class Poses:
    """Poses in their order."""

    poses: tuple[tuple[float, float, float], ...] = parameter(
        meaning="x, y and heading of each; the first is the start", unit="m, m, rad",
        example=((0.0, 0.0, 0.0), (1.0, 0.5, 0.0)),
    )  # fmt: skip
    radius: float = parameter(meaning="smallest turning radius", unit="m", above=0.0, example=0.5)


def joined(shortest: Callable[..., Curves], poses: ArrayLike, radius: float) -> Curves:
    """Return one curve through poses (k, 3): the shortest from each to the next, with a turning radius, m.

    Raises
    ------
    ShapeError
        Fewer than two poses, or all the same.
    OutOfLimits
    """
    p = vectors("poses", poses, 3)
    if p.ndim != 2 or len(p) < 2:
        raise ShapeError(f"poses have shape {p.shape}; they must be (k, 3) with k of at least 2")
    curves = shortest(p[:-1], p[1:], radius)
    pieces = [
        (letter, length)
        for word, row in zip(curves.words, curves.lengths.tolist(), strict=True)
        for letter, length in zip(word, row, strict=False)
        if length
    ]
    if not pieces:
        raise ShapeError("poses: they are all the same; give another one to drive to")
    word = "".join(letter for letter, _ in pieces)
    return Curves(p[:1], curves.radius, (word,), np.array([[length for _, length in pieces]]))


def plan_segments(
    curve: Curves, limits: PathLimits, rest: float, heading: str | None = None, laps: int = 1, start: float = 0.0
) -> ReferencePath:
    """Drive along one curve: from rest to rest over pieces that go on with the same curvature and direction.

    Raises
    ------
    ShapeError
        More than one curve.
    InputError
        Another heading, laps, a turn at the start, which have no meaning here.
    """
    if heading not in (None, "tangent") or laps != 1 or start != 0.0:
        raise InputError(
            f"plan_path: a curve from pose to pose is driven once along its tangent; heading={heading!r}, laps={laps}, "
            f"start={start!r} came; leave them out"
        )
    if len(curve.words) != 1:
        raise ShapeError(f"plan_path: {len(curve.words)} curves came; it plans one")
    radius = curve.radius
    at, parts = curve.start[0] / [radius, radius, 1.0], []
    for turn, length in _joined_pieces(curve):
        k, way = turn / radius, math.copysign(1.0, length)
        s = np.linspace(0.0, radius * abs(length), GRID // 8 + 1)
        distance, v, gain = in_time(s, squared_speeds(s, np.full(len(s), k), limits), limits.rise_time, 0.5 * rest)
        v, gain = np.where(v > _ROUNDING, v, 0.0), np.where(v > _ROUNDING, gain, 0.0)
        pose = turned_poses(at, np.full(len(v), turn), way * np.minimum(distance / radius, abs(length)))
        zero = np.zeros_like(v)
        parts.append(np.column_stack([
            pose * [radius, radius, 1.0], way * v, zero, way * k * v, way * gain, k * v**2, way * k * gain
        ]))  # fmt: skip
        at = turned_poses(at, np.array(turn), np.array(length))
    ends = [np.repeat(row, round(0.5 * rest / TICK), axis=0) for row in (parts[0][:1], parts[-1][-1:])]
    rows = np.concatenate([ends[0], *parts, ends[1]])
    time = TICK * np.arange(len(rows), dtype=np.float64)
    return ReferencePath(time, *(np.ascontiguousarray(rows[:, i : i + 3]) for i in (0, 3, 6)))


def _joined_pieces(curve: Curves) -> list[tuple[float, float]]:
    """Turn (-1, 0, 1) and signed length in radii of the pieces of one curve, those that go on in one as one."""
    found: list[tuple[float, float]] = []
    for letter, length in zip(curve.words[0], curve.lengths[0].tolist(), strict=False):
        if found and found[-1][0] == TURNS[letter] and found[-1][1] * length > 0.0:
            found[-1] = (TURNS[letter], found[-1][1] + length)
        elif length:
            found.append((TURNS[letter], length))
    return found
