"""What stands in the way of bases: outlines on the floor, and how far a base is from them, also along its path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from holonom.app.job import BaseJob, Obstacle
from holonom.arrays import Array
from holonom.geometry import gap, outline
from holonom.mobile import WheelBase, footprint

__all__ = ["Near", "Outline", "base_outline", "first_met", "height_of", "nearest", "outlines_of"]

APART = 0.01  # m and rad between two poses of a path that are looked at
ABOVE = 0.1  # m over its centre of mass, up to which a base is taken to reach


class Outline(NamedTuple):
    """Something on the floor: its corners (k, 2) in the world, a circle around it, and how high it begins, m."""

    name: str
    corners: Array
    middle: Array
    reach: float
    low: float = 0.0


class Near(NamedTuple):
    """What a base comes nearest to: its name, how near (m; below zero inside), and when on its path (s)."""

    name: str
    distance: float
    time: float


def outlines_of(obstacles: Sequence[Obstacle]) -> list[Outline]:
    """Outlines of obstacles."""
    return [
        _made(
            one.name,
            outline(one.shape) @ one.T[:2, :2].T + one.T[:2, 3],
            one.T[:2, 3],
            one.T[2, 3] - one.shape.height / 2,
        )
        for one in obstacles
    ]


def base_outline(corners: Array, pose: Array, name: str = "") -> Outline:
    """Outline of a base whose footprint (k, 2) is known, at a pose (3,)."""
    x, y, turn = pose
    c, s = math.cos(turn), math.sin(turn)
    return _made(name, corners @ np.array([[c, s], [-s, c]]) + [x, y], np.array([x, y]), 0.0)


def nearest(base: Outline, others: Sequence[Outline], height: float) -> tuple[str, float]:
    """The nearest of what lies below a height (m), and how far off, m; below zero inside. Far ones are estimated."""
    best = ("", math.inf)
    for other in others:
        if other.low >= height:
            continue
        least = math.hypot(*(base.middle - other.middle)) - base.reach - other.reach
        if least < best[1]:
            best = min(best, (other.name, gap(base.corners, other.corners)), key=lambda found: found[1])
    return best


def first_met(job: BaseJob, obstacles: Sequence[Obstacle]) -> Near | None:
    """Where a base on its path first runs into an obstacle, else comes nearest to one; None without either."""
    path = job.task.path
    if path is None or not obstacles:
        return None
    others, corners, height = outlines_of(obstacles), footprint(job.base), height_of(job.base)
    way = np.r_[0.0, np.cumsum(np.abs(np.diff(path.pose, axis=0)).sum(axis=1))]
    looked = np.flatnonzero(np.diff(np.floor(way / APART), prepend=-1.0))
    best: Near | None = None
    for k in [*looked, len(way) - 1]:
        name, distance = nearest(base_outline(corners, path.pose[k]), others, height)
        if name and (best is None or distance < best.distance):
            best = Near(name, distance, float(path.time[k]))
            if distance < 0.0:
                return best
    return best


def height_of(base: WheelBase) -> float:
    """Height, m, up to which what stands or hangs there is in its way."""
    return base.com_height + ABOVE


def _made(name: str, corners: Array, middle: Array, low: float) -> Outline:
    return Outline(name, corners, middle, float(np.hypot(*(corners - middle).T).max()), float(low))
