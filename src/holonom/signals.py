"""Records that cross the borders between layers: plain data, SI units, no behaviour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["DriveState", "Event", "FramePoses", "JointCommand", "JointState", "Signal", "Sink"]

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class JointState:
    """Measured joint positions (rad or m), velocities and torques (N m or N), each (n,)."""

    time: float
    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class JointCommand:
    """Reference of the joint servos: position, velocity, acceleration, each (n,)."""

    time: float
    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class DriveState:
    """Motor side of the axes: armature current (A) and voltage (V), each (n,)."""

    time: float
    current: Array
    voltage: Array


@dataclass(frozen=True, slots=True)
class FramePoses:
    """World poses of named frames: `poses` (k, 4, 4), T_wx for x in `names`."""

    time: float
    names: tuple[str, ...]
    poses: Array


@dataclass(frozen=True, slots=True)
class Signal:
    """A digital signal that changed."""

    time: float
    number: int
    on: bool


@dataclass(frozen=True, slots=True)
class Event:
    """Something worth a line in the log. `level`: "debug", "info", "warning" or "error"."""

    time: float
    level: str
    source: str
    text: str
    line: int = 0


class Sink(Protocol):
    """Takes records as they come: the recorder, the studio, a test."""

    def put(self, record: JointState | JointCommand | DriveState | FramePoses | Signal | Event) -> None:
        """Take one record; `record.time` never decreases within one kind."""
