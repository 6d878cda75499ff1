"""The arms that figures are medians over: six and seven joints."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence

from holonom import Arm, load_arm

__all__ = ["ROBOTS", "median", "medians"]

ROBOTS = ("puma560", "ur5e", "panda")


def medians(measure: Callable[[Arm], Sequence[float | None]], robots: Sequence[str] = ROBOTS) -> list[float | None]:
    """Measure every robot and return the median of each number; None where a peer is missing."""
    rows = [measure(load_arm(name)) for name in robots]
    return [median(column) for column in zip(*rows, strict=True)]


def median(values: Sequence[float | None]) -> float | None:
    """Median, None if any value is."""
    known = [v for v in values if v is not None]
    return statistics.median(known) if len(known) == len(values) else None
