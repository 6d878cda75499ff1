"""Work pieces, the surfaces they lie on and the gripper that carries them: discs, rectangles and two fingers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import MotionError
from holonom.model.gravity import GRAVITY
from holonom.spatial import inverse

__all__ = ["Disc", "Fingers", "Gripper", "Surface", "World"]


RESTING, HELD, FALLING = "resting", "held", "falling"
LEAST_OVERLAP = 0.3e-3
"""Height (m) over which fingertips and disc must overlap for a grasp."""
EDGE = 0.05
"""Thickness, m, of a surface under which something else lies."""
LEVEL = math.cos(math.radians(10.0))
"""Cosine of the largest angle between the axes of a hand and a disc that it can grasp."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A horizontal rectangle: pose of its centre T_ws (4, 4), size (m) along its x and y."""

    name: str
    pose: Array
    size: tuple[float, float]

    @property
    def height(self) -> float:
        """Of the surface in the world, m."""
        return float(self.pose[2, 3])

    def spans(self, x: ArrayLike, y: ArrayLike) -> Any:
        """Whether points of the world lie over or under it: x, y (...), m."""
        dx, dy = np.asarray(x) - self.pose[0, 3], np.asarray(y) - self.pose[1, 3]
        along, across = (self.pose[0, k] * dx + self.pose[1, k] * dy for k in (0, 1))
        return (np.abs(along) <= self.size[0] / 2) & (np.abs(across) <= self.size[1] / 2)


@dataclass(frozen=True, slots=True)
class Gripper:
    """Two parallel fingers at +-y of the tool frame, whose z points from the hand to the fingertips (m, m/s)."""

    max_opening: float
    finger_width: float
    finger_thickness: float
    speed: float


@dataclass(slots=True)
class Disc:
    """A flat round part: pose of its centre T_wd, radius and thickness (m), mass (kg)."""

    name: str
    radius: float
    thickness: float
    mass: float
    pose: Array
    state: str = RESTING
    fall_speed: float = 0.0
    in_tool: Array = field(default_factory=lambda: np.eye(4))


class World:
    """What hands can touch: surfaces and discs; `Fingers` move the discs."""

    def __init__(self, surfaces: Sequence[Surface] = (), discs: Sequence[Disc] = ()) -> None:
        self.surfaces, self.discs = list(surfaces), list(discs)

    def under(self, place: ArrayLike, before: Surface | None = None) -> Surface | None:
        """Return the surface that a point (3,) of the world is over, or has sunk into; None where there is none.

        That is the highest one that spans it, of those that are no more than `EDGE` above it: it may be under a shelf,
        over a table. One that it was over `before` stays; where all are far above it, it is inside the highest.
        """
        x, y, z = (float(v) for v in np.asarray(place, dtype=float))
        found = sorted((s for s in self.surfaces if s.spans(x, y)), key=lambda s: s.height)
        near = [s for s in found if s is before or s.height <= z + EDGE]
        return (near or found)[-1] if found else None

    def support(self, disc: Disc) -> float:
        """Height of what lies under a disc's centre: a surface, another disc, the floor."""
        heights = [0.0]
        for surface in self.surfaces:
            if surface.spans(*disc.pose[:2, 3]):
                heights.append(surface.height)
        for other in self.discs:
            apart = np.hypot(*(other.pose[:2, 3] - disc.pose[:2, 3]))
            if other is not disc and other.state == RESTING and apart < other.radius + disc.radius - 0.5e-3:
                heights.append(float(other.pose[2, 3]) + other.thickness / 2)
        return max(h for h in heights if h <= disc.pose[2, 3])


class Fingers:
    """A gripper in a world. `step` is called once per program tick. Mutable state: `opening`, `held`, what falls."""

    def __init__(self, world: World, gripper: Gripper) -> None:
        self.world, self.gripper = world, gripper
        self.opening = gripper.max_opening
        self.held: Disc | None = None
        """The disc between the fingers."""
        self._dropped: list[Disc] = []
        self._wanted = self.opening
        self._blocked = 0.0

    @property
    def idle(self) -> bool:
        """Whether the fingers stand where they were sent, or on a part."""
        return abs(self.opening - max(self._wanted, self._blocked)) < 1e-9

    @property
    def hang(self) -> float:
        """How far what is held reaches beyond the fingertips along the tool's z, m; 0 where nothing is held."""
        disc = self.held
        if disc is None:
            return 0.0
        T, up = disc.in_tool, abs(float(disc.in_tool[2, 2]))
        rim = disc.radius * math.sqrt(max(1.0 - up * up, 0.0))
        return max(float(T[2, 3]) + 0.5 * disc.thickness * up + rim, 0.0)

    @property
    def payload(self) -> Array:
        """Mass (kg) and centre of mass (m, tool frame) of what is held: (4,)."""
        disc = self.held
        return np.zeros(4) if disc is None else np.array([disc.mass, *disc.in_tool[:3, 3]])

    def send(self, opening: float) -> None:
        """Send the fingers to an opening (m)."""
        self._wanted = min(max(opening, 0.0), self.gripper.max_opening)

    def step(self, T_wt: Array, dt: float) -> list[str]:
        """Advance by `dt` with the tool at T_wt; return what happened, in words.

        Raises
        ------
        MotionError
            A finger came down on a part.
        """
        happened = self._move_fingers(T_wt, dt)
        if self.held is not None:
            self.held.pose = T_wt @ self.held.in_tool
        for disc in list(self._dropped):
            happened += self._fall(disc, dt)
        self._check_fingers(T_wt)
        return happened

    def _move_fingers(self, T_wt: Array, dt: float) -> list[str]:
        way = self.gripper.speed * dt
        held = self.held
        self._blocked = 2.0 * held.radius if held else 0.0
        if self._wanted > self.opening:
            self.opening = min(self.opening + way, self._wanted)
            if held is not None and self.opening > self._blocked:
                held.state, held.fall_speed, self.held = FALLING, 0.0, None
                self._dropped.append(held)
                self._blocked = 0.0
                return [f"released {held.name}"]
            return []
        before = self.opening
        self.opening = max(self.opening - way, self._wanted, self._blocked)
        if held is None and self.opening < before:
            return self._squeeze(T_wt)
        return []

    def _squeeze(self, T_wt: Array) -> list[str]:
        """Push a disc to the middle of the closing fingers, and hold it once both are on it."""
        to_tool = inverse(T_wt)
        for disc in self.world.discs:
            in_tool = to_tool @ disc.pose
            if disc.state != RESTING or not self._between_fingers(disc, in_tool):
                continue
            room = max(self.opening / 2 - disc.radius, 0.0)
            if abs(in_tool[1, 3]) > room:
                in_tool[1, 3] = np.clip(in_tool[1, 3], -room, room)
                disc.pose = T_wt @ in_tool
            if room == 0.0:
                disc.state, disc.in_tool, self.held = HELD, in_tool, disc
                self._blocked = self.opening = 2.0 * disc.radius
                return [f"grasped {disc.name}"]
        return []

    def _between_fingers(self, disc: Disc, in_tool: Array) -> bool:
        """Whether a disc's edges face both fingers, high enough on the disc, with hand and disc level."""
        x, y, z = in_tool[:3, 3]
        overlap = disc.thickness / 2 - z  # of disc and fingers, which end at z = 0
        beside = abs(x) < self.gripper.finger_width / 2 and abs(y) < disc.radius
        return bool(beside and overlap > LEAST_OVERLAP and abs(in_tool[2, 2]) > LEVEL)

    def _fall(self, disc: Disc, dt: float) -> list[str]:
        disc.fall_speed += GRAVITY * dt
        floor = self.world.support(disc) + disc.thickness / 2
        z = disc.pose[2, 3] - disc.fall_speed * dt
        disc.pose = disc.pose.copy()
        if z > floor:
            disc.pose[2, 3] = z
            return []
        flat = np.eye(4)
        flat[:3, 3] = disc.pose[0, 3], disc.pose[1, 3], floor
        disc.pose, disc.state = flat, RESTING
        self._dropped.remove(disc)
        return [f"{disc.name} lies at {1e3 * flat[0, 3]:.1f}, {1e3 * flat[1, 3]:.1f}, {1e3 * flat[2, 3]:.1f} mm"]

    def _check_fingers(self, T_wt: Array) -> None:
        """No finger may stand in a disc: fingertips are rectangles in the tool's x-y plane."""
        tip = T_wt[2, 3]
        low = [
            d for d in self.world.discs if d.state == RESTING and tip < d.pose[2, 3] + d.thickness / 2 - LEAST_OVERLAP
        ]
        if not low:
            return
        centres = (inverse(T_wt) @ np.stack([d.pose[:, 3] for d in low], axis=1))[:2]
        dx = np.maximum(np.abs(centres[0]) - self.gripper.finger_width / 2, 0.0)
        for side in (-1.0, 1.0):
            middle = side * (self.opening + self.gripper.finger_thickness) / 2
            dy = np.maximum(np.abs(centres[1] - middle) - self.gripper.finger_thickness / 2, 0.0)
            for disc, gap in zip(low, np.hypot(dx, dy), strict=True):
                if gap < disc.radius - 0.5e-3:
                    raise MotionError(
                        f"a finger hit {disc.name} ({1e3 * (disc.radius - gap):.1f} mm inside its edge); "
                        "approach it more centrally, from another angle or with another opening"
                    )
