"""What robots may not hit: bases by what they cover of the floor, arms as lines between joints, boxes and cylinders."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from holonom.app.cell.in_the_way import Outline, base_outline, height_of, nearest, outlines_of
from holonom.app.cell.surroundings import link_points
from holonom.app.job import Obstacle
from holonom.app.rig.arm import ArmRig
from holonom.app.rig.base import BaseRig
from holonom.app.rig.robot import RobotRig
from holonom.arrays import Array
from holonom.geometry import distance
from holonom.mobile import footprint
from holonom.spatial import inverse

__all__ = ["Collisions", "Hit"]


class Hit(NamedTuple):
    """A robot that hit something, in words."""

    robot: RobotRig
    text: str


class Collisions:
    """Looks each tick whether a robot has hit an obstacle, or a base another base."""

    def __init__(self, obstacles: Sequence[Obstacle]) -> None:
        self._obstacles = [(obstacle, inverse(obstacle.T)) for obstacle in obstacles]
        self._outlines = outlines_of(obstacles)
        self._footprints: dict[str, Array] = {}

    def first(self, bases: Iterable[BaseRig], arms: Iterable[ArmRig]) -> Hit | None:
        """Return the first hit that is found, None if there is none."""
        bases = list(bases)
        places = {base.name: self._place(base) for base in bases} if self._obstacles or len(bases) > 1 else {}
        for base, other in itertools.combinations(bases, 2):
            if nearest(places[base.name], [places[other.name]], np.inf)[1] < 0.0:
                moving = other if other.speed > base.speed else base
                return Hit(moving, f"it hit {base.name if moving is other else other.name}")
        if not self._obstacles:
            return None
        for base in bases:
            name, away = nearest(places[base.name], self._outlines, height_of(base.job.base))
            if away < 0.0:
                return Hit(base, f"{'it' if base.name else 'the base'} hit {name}")
        for arm in arms:
            points = link_points(arm.arm.frames())
            for obstacle, T in self._obstacles:
                if (distance(obstacle.shape, points @ T[:3, :3].T + T[:3, 3]) <= 0.0).any():
                    return Hit(arm, f"{'it' if arm.name else 'the arm'} hit {obstacle.name}")
        return None

    def _place(self, base: BaseRig) -> Outline:
        if base.name not in self._footprints:
            self._footprints[base.name] = footprint(base.job.base)
        return base_outline(self._footprints[base.name], base.loop.plant.pose, base.name)
