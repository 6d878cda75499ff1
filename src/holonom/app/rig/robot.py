"""`RobotRig`: a robot of a rig, as the rig sees it."""

from __future__ import annotations

from typing import Any, Protocol

from holonom.machine.supervisor import Stoppable

__all__ = ["TICK", "RobotRig"]

TICK = 0.01
"""Interval of programs, signals and recording, s."""


class RobotRig(Stoppable, Protocol):
    """A robot with what it is to do."""

    @property
    def done(self) -> bool:
        """Whether it has done what it was to do, or stands at PAUSE."""

    @property
    def paused(self) -> bool:
        """Whether its program stands at PAUSE."""

    @property
    def truth(self) -> Any:
        """What sensors of the cell may see of it."""

    def think(self) -> None:
        """Let its program or task go on; `RunError` where that fails."""

    def advance(self, ticks: int) -> None:
        """Advance by some ticks; `RunError` where it had to stop."""

    def explain(self, fault: Exception) -> str:
        """Word a fault, with the program line that it came of."""

    def log(self, level: str, source: str, text: str) -> None:
        """Record an event of it."""
