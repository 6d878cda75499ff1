"""Records that cross the borders between layers: plain data, SI units, no behaviour."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "BaseCommand",
    "BaseState",
    "DriveState",
    "Event",
    "FramePoses",
    "Inertial",
    "JointCommand",
    "JointState",
    "Record",
    "Signal",
    "Sink",
    "WheelContact",
]

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
class BaseState:
    """Where a mobile base believes to be.

    Pose (3,): x, y, theta of base_link in odom; its `covariance` (3, 3); twist (3,): vx, vy, w in base_link.
    """

    time: float
    pose: Array
    twist: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class BaseCommand:
    """Reference of a mobile base: pose (3,) in odom and twist (3,) in base_link."""

    time: float
    pose: Array
    twist: Array


@dataclass(frozen=True, slots=True)
class Inertial:
    """What a gyro and accelerometers on base_link measure: turning rate (rad/s) about z, acceleration (2,) m/s2."""

    time: float
    rate: float
    acceleration: Array


@dataclass(frozen=True, slots=True)
class WheelContact:
    """Wheels on the ground, each (n,).

    Driving force (N); slip, the rim's speed over the ground (m/s); the rim speed that no twist explains (m/s).
    """

    time: float
    force: Array
    slip: Array
    residual: Array


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


Record = (
    JointState
    | JointCommand
    | DriveState
    | BaseState
    | BaseCommand
    | Inertial
    | WheelContact
    | FramePoses
    | Signal
    | Event
)
"""Any of them."""


class Sink(Protocol):
    """Takes records as they come: the recorder, the studio, a test."""

    def put(self, record: Record) -> None:
        """Take one record; `record.time` never decreases within one kind."""
