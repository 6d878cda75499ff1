"""`Group`: an arm on a base: where the arm's own base is, as the base that carries it believes to stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.machine.base.controller import BaseController

__all__ = ["Group", "planar_pose"]


def planar_pose(pose: ArrayLike) -> Array:
    """T (4, 4) of a base_link at (x, y, theta) on the floor."""
    x, y, theta = np.asarray(pose, float)
    T = np.eye(4)
    T[0, 0] = T[1, 1] = math.cos(theta)
    T[1, 0] = math.sin(theta)
    T[0, 1] = -T[1, 0]
    T[:2, 3] = x, y
    return T


@dataclass(frozen=True, slots=True)
class Group:
    """A base that carries an arm: T (4, 4) from base_link to the arm's own base."""

    base: BaseController
    mount: Array

    def frame(self) -> Array:
        """T (4, 4) of the arm's base in odom, by the base's estimate: poses of a program are taken from here."""
        found: Array = planar_pose(self.base.pose) @ self.mount
        return found
