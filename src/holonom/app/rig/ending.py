"""How a run ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from holonom.errors import RunError

__all__ = ["Ended", "Ending"]


class Ending(StrEnum):
    """What a run came to."""

    DONE = "done"
    """Every robot has done what it was to do."""
    PAUSED = "paused"
    """A program stands at PAUSE, and nothing else is to be done."""
    FAILED = "failed"
    """A fault stopped it."""
    STOPPED = "stopped"
    """The operator stopped it."""


@dataclass(frozen=True, slots=True)
class Ended:
    """The ending of a run: what, why (a sentence), at which simulated time (s), and the fault if there was one."""

    ending: Ending
    reason: str
    time: float
    fault: RunError | None = None
