"""What robots may not hit: bases as discs, arms as the lines between their joints, obstacles as boxes and cylinders."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from holonom.app.cell.surroundings import link_points
from holonom.app.job import Obstacle
from holonom.app.rig.arm import ArmRig
from holonom.app.rig.base import BaseRig
from holonom.app.rig.robot import RobotRig
from holonom.geometry import distance
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

    def first(self, bases: Iterable[BaseRig], arms: Iterable[ArmRig]) -> Hit | None:
        """Return the first hit that is found, None if there is none."""
        bases = list(bases)
        for base, other in itertools.combinations(bases, 2):
            away = math.hypot(*(base.loop.plant.pose - other.loop.plant.pose)[:2])
            if away < _reach(base) + _reach(other):
                moving = other if other.speed > base.speed else base
                return Hit(moving, f"it hit {base.name if moving is other else other.name}")
        if not self._obstacles:
            return None
        for base in bases:
            x, y, _ = base.loop.plant.pose
            for obstacle, T in self._obstacles:
                low = float(obstacle.T[2, 3]) - 0.5 * obstacle.shape.height
                here = T @ np.array([x, y, obstacle.T[2, 3], 1.0])
                if low < base.job.base.com_height + 0.1 and distance(obstacle.shape, here[:3]) < _reach(base):
                    return Hit(base, f"{'it' if base.name else 'the base'} hit {obstacle.name}")
        for arm in arms:
            points = link_points(arm.arm.frames())
            for obstacle, T in self._obstacles:
                if (distance(obstacle.shape, points @ T[:3, :3].T + T[:3, 3]) <= 0.0).any():
                    return Hit(arm, f"{'it' if arm.name else 'the arm'} hit {obstacle.name}")
        return None


def _reach(base: BaseRig) -> float:
    return max(math.hypot(wheel.x, wheel.y) for wheel in base.job.base.wheels)
