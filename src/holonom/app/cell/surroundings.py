"""`Surroundings`: where a motion would bring the tool, the hand or what it holds into a surface or an obstacle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.app.job import Obstacle
from holonom.arrays import Array
from holonom.geometry import distance
from holonom.mechanics import Arm
from holonom.mechanics.motion import Trajectory
from holonom.sim import Gripper, Surface, World
from holonom.sim.arm.world import EDGE
from holonom.spatial import inverse

__all__ = ["Found", "Reach", "Surroundings", "link_points"]

SAMPLES = 200
"""Samples of a motion that are looked at."""
TOUCH = 1e-3
"""Depth, m, up to which a tool only touches a surface."""
POINTS = 12
"""Points of each link that are looked at."""
WHOLE = 20_000
"""Samples up to which those of a motion are made at once."""


class Reach(NamedTuple):
    """What is at the end of an arm: how far its fingers are open, how far what they hold reaches beyond them, m."""

    opening: float = 0.0
    hang: float = 0.0


class Found(NamedTuple):
    """Something that a motion would run into, in words; how deep, m; inf in an obstacle."""

    text: str
    depth: float


class Surroundings:
    """The surfaces and obstacles of a cell as an arm meets them.

    Parameters
    ----------
    arm
        The arm with its tool.
    gripper
        Its hand, None without one.
    world
        The surfaces.
    obstacles
        What nothing may hit.
    """

    def __init__(self, arm: Arm, gripper: Gripper | None, world: World, obstacles: Sequence[Obstacle]) -> None:
        self._arm, self._gripper, self._world = arm, gripper, world
        self._obstacles = [(obstacle, inverse(obstacle.T)) for obstacle in obstacles]

    def met_by(self, motion: Trajectory, base: Array, reach: Reach) -> Found | None:
        """Return what a motion runs into, the deepest place; None where it is free.

        Parameters
        ----------
        motion
            Joints by time.
        base
            T (4, 4) from the world to that in which the arm's frames are.
        reach
            What is at its end.
        """
        if not self._world.surfaces and not self._obstacles:
            return None
        numbers = np.unique(np.linspace(0, motion.count - 1, SAMPLES).round().astype(np.int64))
        frames = np.asarray(base @ self._arm.frames(_positions(motion, numbers)))
        share = 100.0 * numbers / max(motion.count - 1, 1)
        return self._obstacle(frames, share) or self._surface(frames, share, reach)

    def _obstacle(self, frames: Array, share: Array) -> Found | None:
        points = link_points(frames)
        for obstacle, T in self._obstacles:
            local = points @ T[:3, :3].T + T[:3, 3]
            inside = np.array([(distance(obstacle.shape, row) <= 0.0).any() for row in local])
            if inside.any():
                return Found(f"the arm would hit {obstacle.name} at {share[np.argmax(inside)]:.0f} %", np.inf)
        return None

    def _surface(self, frames: Array, share: Array, reach: Reach) -> Found | None:
        worst: tuple[float, str] = (TOUCH, "")
        for name, points in self._parts(frames, reach):
            for surface in self._world.surfaces:
                depth = self._depth(surface, points)
                k = np.unravel_index(int(np.argmax(depth)), depth.shape)
                begins = k[0] == 0 and len(share) > 1  # the motion that led there is told of it
                if depth[k] > worst[0] and not begins:
                    x, y, z = 1e3 * points[k]
                    place = f"at ({x:.0f}, {y:.0f}, {z:.0f}) mm, {share[k[0]]:.0f} % of the motion"
                    text = f"{name} would be {1e3 * depth[k]:.1f} mm inside {surface.name} {place}"
                    worst = (float(depth[k]), text)
        return Found(worst[1], worst[0]) if worst[1] else None

    def _depth(self, surface: Surface, points: Array) -> Array:
        """How deep points (N, k, 3) of a motion are in a surface, (N, k); 0 under it where they go over another one."""
        x, y, z = np.moveaxis(points, -1, 0)
        low = surface.height - z
        others = [s.spans(x, y) for s in self._world.surfaces if s.height < surface.height - EDGE]
        beneath = np.any(others, axis=0) if others else np.zeros(z.shape, dtype=bool)
        passes = beneath & (low > EDGE) & (low[0] > TOUCH)
        return np.where(surface.spans(x, y) & ~passes, low, 0.0)

    def _parts(self, frames: Array, reach: Reach) -> list[tuple[str, Array]]:
        """What is looked at: names, and points (N, k, 3) in the world."""
        tool = frames[:, -1]
        found = [("the flange", frames[:, -2:-1, :3, 3])]
        found.append(("the tool", tool[:, None, :3, 3]))
        if self._gripper is not None:
            wide, out = 0.5 * self._gripper.finger_width, 0.5 * reach.opening + self._gripper.finger_thickness
            corners = np.array([(x, y, 0.0) for x in (-wide, wide) for y in (-out, out)])
            found.append(("a finger", _placed(tool, corners)))
        if reach.hang > 0.0:
            found.append(("the held part", _placed(tool, np.array([(0.0, 0.0, reach.hang)]))))
        return found


def link_points(frames: Array) -> Array:
    """Points (..., k, 3) along the lines between an arm's frames (..., m, 4, 4); its own base is not one."""
    places = frames[..., 1:, :3, 3]
    s = np.linspace(0.0, 1.0, POINTS)[:, None, None]
    found = places[..., None, :-1, :] + s * (places[..., 1:, :] - places[..., :-1, :])[..., None, :, :]
    return np.asarray(found.reshape(*places.shape[:-2], -1, 3))


def _placed(tool: Array, points: Array) -> Array:
    """Points (k, 3) of the tool's frame in the world, for tool poses (N, 4, 4): (N, k, 3)."""
    placed: Array = np.einsum("nij,kj->nki", tool[:, :3, :3], points) + tool[:, None, :3, 3]
    return placed


def _positions(motion: Trajectory, numbers: NDArray[np.int64]) -> Array:
    if motion.count <= WHOLE:
        found: Array = motion.q[numbers]
        return found
    return np.concatenate([motion.take(int(k), int(k) + 1)[0] for k in numbers])
