"""Joint limits, and what the limits of a joint that follows another one mean for the one it follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = ["LIMIT_TOLERANCE", "JointLimits", "outside"]

LIMIT_TOLERANCE = 1e-6
"""Angle (rad) or way (m) by which a joint may pass a position limit: rounding of files and of single precision."""


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Position (rad or m), speed, acceleration and torque limits; infinite where none is stated.

    A position counts as within them up to `LIMIT_TOLERANCE` beyond; every verb uses that one tolerance.
    """

    lower: float = -np.inf
    upper: float = np.inf
    speed: float = np.inf
    acceleration: float = np.inf
    torque: float = np.inf

    def leading(self, follower: JointLimits, multiplier: float, offset: float) -> JointLimits:
        """These limits, narrowed to what a follower at `multiplier * q + offset` may do.

        The follower's motions are |multiplier| times the leader's, and by the principle of virtual work a torque on it
        weighs |multiplier| times as much on the leader.
        """
        if multiplier == 0.0:
            return self
        ends = sorted(((follower.lower - offset) / multiplier, (follower.upper - offset) / multiplier))
        times = abs(multiplier)
        return JointLimits(
            max(self.lower, ends[0]),
            min(self.upper, ends[1]),
            min(self.speed, follower.speed / times),
            min(self.acceleration, follower.acceleration / times),
            min(self.torque, follower.torque * times),
        )


def outside(q: Array | float, lower: Array | float, upper: Array | float) -> NDArray[np.bool_]:
    """Which positions (..., n) lie outside limits (n,), by more than `LIMIT_TOLERANCE`."""
    return np.asarray((q < lower - LIMIT_TOLERANCE) | (q > upper + LIMIT_TOLERANCE))
