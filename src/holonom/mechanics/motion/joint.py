"""Point to point: all joints leave and arrive together, each within its limits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, real_array
from holonom.errors import OutOfLimits
from holonom.mechanics.motion.profile import Grid, grid_of, time_law
from holonom.mechanics.motion.trajectory import (
    STILL,
    JointLimits,
    Trajectory,
    check_inside,
    joint_vector,
    standstill,
)

__all__ = ["plan_joint"]


def plan_joint(
    q0: ArrayLike,
    q1: ArrayLike,
    limits: JointLimits,
    *,
    speed: float = 1.0,
    acceleration: float = 1.0,
    jerk: ArrayLike = inf,
    dt: float = 1e-3,
    profile: str = "scurve",
    line: int = 0,
) -> Trajectory:
    """Synchronised joint motion from rest to rest, straight in joint space.

    Parameters
    ----------
    q0, q1
        Start and goal, each (n,), rad or m.
    limits
        Joint limits; `q1` has to lie inside them.
    speed, acceleration
        Fractions of the joints' limits that may be used, in (0, 1].
    jerk
        Largest jerk of the joints, one for all or (n,), rad/s^3 or m/s^3; none by default.
    dt
        Time between samples (s).
    profile
        A name in `PROFILES`.
    line
        Source line to carry along.

    Returns
    -------
    Trajectory
        One time law for all joints, q = q0 + (q1 - q0) s(t), set by the joint that needs most time; ramp and
        cruise are rounded up to whole samples. The first sample is `q0`, the last `q1`, both exactly.

    Raises
    ------
    OutOfLimits
        A joint of `q1` outside its limits, or a fraction outside (0, 1].
    ShapeError
        Vectors of the wrong size, or not finite.
    UnknownName
        No such profile.
    """
    n = limits.lower.shape[0]
    start, goal = joint_vector("q0", q0, n), joint_vector("q1", q1, n)
    check_inside(goal, limits)
    _check_fraction("speed", speed)
    _check_fraction("acceleration", acceleration)
    way = goal - start
    moves = np.abs(way) > STILL
    if not moves.any():
        return standstill(goal, dt, line)

    def least(limit: Array) -> float:
        return float(np.min(limit[moves] / np.abs(way[moves])))

    law = time_law(
        1.0,
        speed * least(limits.speed),
        acceleration * least(limits.acceleration),
        least(np.broadcast_to(real_array("jerk", jerk), (n,))),
        profile=profile,
    )
    grid = grid_of(law, dt)
    return Trajectory.of(dt, JointRows(grid, start, goal), line, brake=grid.brake)


@dataclass(frozen=True, slots=True)
class JointRows:
    """Samples `offset`, ... of a law from `start` (n,) to `goal` (n,), straight in joint space."""

    grid: Grid
    start: Array
    goal: Array
    offset: int = 0

    @property
    def count(self) -> int:
        """How many there are."""
        return self.grid.count - self.offset

    def take(self, first: int, last: int) -> Array:
        """See `Rows`."""
        numbers = np.arange(first + self.offset, min(last + self.offset, self.grid.count))
        s, ds, dds = (values[:, None] for values in self.grid.at(numbers))
        way = self.goal - self.start
        q = self.start + s * way
        q[numbers == self.grid.count - 1] = self.goal
        return np.stack([q, ds * way, dds * way])

    def after(self, number: int) -> JointRows:
        """See `Rows`."""
        return replace(self, offset=self.offset + number)


def _check_fraction(name: str, value: float) -> None:
    if not 0.0 < value <= 1.0:
        raise OutOfLimits(f"{name} fraction {value}: give one above 0 and up to 1 (1 = the joints' limits)")
