"""`MotionQueue`: the motions that an arm was told to make, as reference samples; blending, braking on the path."""

from __future__ import annotations

from math import inf

import numpy as np

from holonom.arrays import Array
from holonom.errors import LevelFault
from holonom.machine.arm.motions import LineSettings, MotionRequest, plan
from holonom.machine.levels import Levels, LevelState, PointBuffer
from holonom.mechanics import Arm
from holonom.mechanics.motion import Trajectory, splice, stop

__all__ = ["MotionQueue"]


class MotionQueue:
    """The supervisor of an arm's path: one motion under way and one that may be blended into it.

    Mutable state: the planned trajectory, how much of it was given out, the points that the servos hold.

    Parameters
    ----------
    arm
        Which the motions are planned for.
    q
        Joints (n,), rad, where it stands.
    line
        What 100 % means on straight lines.
    levels
        Where the supervisor's period is longer than the servos', they get points and interpolate.
    longest
        Longest time that a motion may take, s.
    """

    def __init__(
        self, arm: Arm, q: Array, line: LineSettings, levels: Levels = Levels(), *, longest: float = inf
    ) -> None:
        self.arm, self.line, self.levels, self.longest = arm, line, levels, longest
        self.place(q)
        self.tolerance = "coarse"
        """How closely the last motion is to settle."""
        self._line_before = 0
        self._blend = True

    def place(self, q: Array) -> None:
        """Stand at q (n,), without any motion."""
        rest = np.zeros((1, q.shape[0]))
        self._follow(Trajectory(self.levels.servo, q[None].copy(), rest, rest.copy()))
        self._used = 1
        self._points: PointBuffer | None = None
        if self.levels.ratio > 1:
            limits = self.arm.limits
            self._points = PointBuffer(
                "the supervisor", q, self.levels, speed=1.1 * limits.speed, acceleration=limits.acceleration
            )

    @property
    def empty(self) -> bool:
        """Whether all that was planned was given out."""
        standing = self._points is None or self._points.state is LevelState.STANDING
        return self._used >= self.planned.count and standing

    @property
    def goal(self) -> Array:
        """Joints (n,) where the last motion ends."""
        return self._goal.copy()

    @property
    def active_line(self) -> int:
        """Source line of the motion under way, 0 when standing."""
        if self._used >= self.planned.count:
            return 0
        return self.planned.line if self._used >= self.planned.begin else self._line_before

    def move(self, motion: MotionRequest, *, idle: bool) -> bool:
        """Take a motion, blended into the present one if both allow it; False while one is already waiting.

        `idle`: whether the arm has ended and settled the last one.

        Raises
        ------
        MotionError
            It cannot be made.
        """
        if idle:
            self._follow(self._plan(motion))
        elif self._blend and self._used >= self.planned.begin:
            following = self._plan(motion)
            self._line_before = self.active_line
            self._follow(splice(self.planned, self._used, following, self.arm.limits))
        else:
            return False
        self._blend, self.tolerance = motion.blend, motion.tolerance
        return True

    def brake(self) -> None:
        """Replace what is planned by the shortest way to rest along it."""
        at = min(self._used, self.planned.count - 1)
        self._follow(stop(self.planned, at, self.arm.limits))
        self._blend = False

    def take(self, count: int) -> Array:
        """Return the reference of the next servo periods (3, count, n); at the end the last one is held.

        Raises
        ------
        LevelFault
            The supervisor failed, and the arm stands.
        """
        if self._points is None:
            first = min(self._used, self.planned.count - 1)
            rows = self.planned.take(first, min(self._used + count, self.planned.count))
            self._used = min(self._used + count, self.planned.count)
            missing = count - rows.shape[1]
            return rows if missing <= 0 else np.concatenate([rows, np.repeat(rows[:, -1:], missing, axis=1)], axis=1)
        while self._points.held < count and self._used < self.planned.count:
            self._used = min(self._used + self.levels.ratio, self.planned.count)
            self._points.push(self._sample(min(self._used, self.planned.count - 1))[0])
        reference = self._points.take(count)
        if self._points.reason and self._points.state is LevelState.STANDING:
            raise LevelFault(self._points.reason)
        return reference

    def present(self) -> Array:
        """The reference (3, n) of this instant: the sample that the next tick begins with."""
        if self._points is not None:
            return np.stack([self._points.position, self._points.rate, np.zeros_like(self._points.rate)])
        return self._sample(min(self._used, self.planned.count - 1))

    def _plan(self, motion: MotionRequest) -> Trajectory:
        return plan(self.arm, self._goal, motion, self.line, self.levels.servo, longest=self.longest)

    def _follow(self, planned: Trajectory) -> None:
        """Follow a trajectory from its first sample on."""
        self.planned, self._used, self._goal = planned, 0, planned.end

    def _sample(self, number: int) -> Array:
        """One sample of what is planned (3, n)."""
        return self.planned.take(number, number + 1)[:, 0]
