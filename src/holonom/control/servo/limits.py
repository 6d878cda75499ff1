"""Limits of one axis and the named cause when one is left (spec 04.4)."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from holonom.control.servo.kernels import LimitParams
from holonom.errors import DriveFault, OutOfLimits

__all__ = ["AxisLimits", "Violation", "drive_fault"]


class Violation(enum.IntEnum):
    """What `axis_violation` found; the first in this order."""

    NONE = 0
    LOST_REFERENCE = 1
    POSITION_LOW = 2
    POSITION_HIGH = 3
    FOLLOWING_ERROR = 4
    SPEED = 5
    CURRENT = 6


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Limits at which an axis is stopped, all in the units of the axis they watch (`unit`: rad or m; A).

    `speed` and `current` are trips: set them above the limits to which the cascade clips its references, or
    an ordinary overshoot stops the axis.

    Raises
    ------
    OutOfLimits
        A range that is empty or NaN, or a limit that is not positive; infinity means no limit.
    """

    lower: float
    upper: float
    speed: float
    current: float
    following_error: float
    unit: str = "rad"

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise OutOfLimits(f"AxisLimits: lower is {self.lower!r}, upper {self.upper!r}; lower must be less")
        for field in ("speed", "current", "following_error"):
            value = getattr(self, field)
            if not value > 0.0:
                raise OutOfLimits(f"AxisLimits: {field} is {value!r}; it must be greater than 0 (inf: no limit)")

    def params(self) -> LimitParams:
        """Params of `axis_violation`."""
        return LimitParams(self.lower, self.upper, self.speed, self.current, self.following_error)


def drive_fault(
    violation: Violation,
    limits: AxisLimits,
    *,
    axis: str,
    time: float,
    reference: float,
    position: float,
    speed: float,
    current: float,
) -> DriveFault:
    """The error to raise for a violation: axis, time, cause, value and limit.

    Parameters
    ----------
    violation
        What `axis_violation` returned, not `NONE`.
    limits
        The limits it was given.
    axis, time
        Name of the axis; time of the stop in s.
    reference, position, speed, current
        The values at that moment, in the units of the limits.
    """
    error, unit = reference - position, limits.unit
    causes = {
        Violation.LOST_REFERENCE: f"lost reference: the commanded position is {reference!r}",
        Violation.POSITION_LOW: f"position {position:.6g} {unit} is below its limit {limits.lower:.6g} {unit}",
        Violation.POSITION_HIGH: f"position {position:.6g} {unit} is above its limit {limits.upper:.6g} {unit}",
        Violation.FOLLOWING_ERROR: f"following error {error:.6g} exceeds {limits.following_error:.6g} {unit}",
        Violation.SPEED: f"speed {speed:.6g} {unit}/s exceeds {limits.speed:.6g} {unit}/s",
        Violation.CURRENT: f"current {current:.6g} A exceeds {limits.current:.6g} A",
    }
    advice = "command within the limits, more slowly, or with less load"
    return DriveFault(f"axis {axis!r} stopped at {time:.4f} s: {causes[violation]}; {advice}")
