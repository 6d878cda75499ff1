"""The protocol between a controller and what it drives: simulation, rehearsal, a recording or a bus are its ends.

What passes each step are the arrays of `devices.drive_signals`; here is what is asked of whole drives and hands.
"""

from __future__ import annotations

from typing import Protocol

from holonom.arrays import Array

__all__ = ["ArmDrives", "Hand"]


class ArmDrives(Protocol):
    """The drives of n joints, which follow references; all values are measured ones."""

    @property
    def time(self) -> float:
        """Time of the drives' clock, s."""

    @property
    def position(self) -> Array:
        """Joint positions (n,), rad or m."""

    @property
    def speed(self) -> Array:
        """Joint speeds (n,), rad/s or m/s."""

    def advance(self, reference: Array) -> None:
        """Follow samples (3, ticks, n): positions, speeds, accelerations; `DriveFault` where a limit is left."""

    def brake(self, ticks: int) -> None:
        """Hold zero speed for some ticks, whatever the reference was."""

    def at_limit(self) -> tuple[str, ...]:
        """Return for each joint which limit of its drive it is at, in words; "" where at none."""


class Hand(Protocol):
    """A hand and what it holds."""

    @property
    def max_opening(self) -> float:
        """How far it opens, m."""

    @property
    def idle(self) -> bool:
        """Whether it has arrived where it was sent, or on a part."""

    def send(self, opening: float) -> None:
        """Send the fingers to an opening, m."""

    def step(self, dt: float) -> list[str]:
        """Let some time (s) pass; return what happened, in words. `MotionError` where a finger hit something."""
