"""Reference paths from pose to pose, of arcs and straights, for bases that cannot turn on the spot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import vectors
from holonom.errors import ShapeError
from holonom.machine.base.timing import GRID, TICK, PathLimits, ReferencePath, in_time, squared_speeds
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


def plan_segments(curve: Curves, limits: PathLimits, rest: float) -> ReferencePath:
    """Drive along segments: from rest to rest over those that go on with the same curvature and direction."""
    if curve.kinds.ndim != 1:
        raise ShapeError(f"plan_path: {curve.kinds.shape[:-1]} curves came; it plans one")
    kinds, sizes = curve.kinds, curve.lengths
    ends = np.cumsum(np.abs(sizes)) * curve.radius
    same = (kinds[1:] == kinds[:-1]) & (np.sign(sizes[1:]) == np.sign(sizes[:-1]))
    stops = np.concatenate([[0.0], ends[:-1][~same], ends[-1:]])
    first = np.concatenate([[0], 1 + np.flatnonzero(~same)])
    parts = []
    for i, begin, end in zip(first, stops[:-1], stops[1:], strict=True):
        k, way = kinds[i] / curve.radius, math.copysign(1.0, sizes[i])
        s = np.linspace(0.0, end - begin, GRID // 8 + 1)
        distance, v, gain = in_time(s, squared_speeds(s, np.full(len(s), k), limits), limits.rise_time, 0.5 * rest)
        v, gain = np.where(v > _ROUNDING, v, 0.0), np.where(v > _ROUNDING, gain, 0.0)
        pose = curve.poses(begin + np.minimum(distance, end - begin))
        zero = np.zeros_like(v)
        parts.append(np.column_stack([pose, way * v, zero, way * k * v, way * gain, k * v**2, way * k * gain]))
    ends_ = [np.repeat(row, round(0.5 * rest / TICK), axis=0) for row in (parts[0][:1], parts[-1][-1:])]
    rows = np.concatenate([ends_[0], *parts, ends_[1]])
    time = TICK * np.arange(len(rows), dtype=np.float64)
    return ReferencePath(time, *(np.ascontiguousarray(rows[:, i : i + 3]) for i in (0, 3, 6)))
