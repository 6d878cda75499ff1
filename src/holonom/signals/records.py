"""The records that cross the borders between layers: plain data in SI units, and who takes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = [
    "BaseCommand",
    "BaseState",
    "BaseTruth",
    "DriveState",
    "DriveTruth",
    "EncoderCounts",
    "Event",
    "FixedFrames",
    "FramePoses",
    "FrameTree",
    "Inertial",
    "JointCommand",
    "JointState",
    "JointTruth",
    "Marker",
    "Markers",
    "Photograph",
    "Pitch",
    "Reading",
    "Record",
    "RobotDescription",
    "Signal",
    "Sink",
    "Steering",
    "WheelContact",
    "WheelLoad",
]


@dataclass(frozen=True, slots=True)
class Record:
    """What every record has: its time, s."""

    time: float


@dataclass(frozen=True, slots=True)
class JointState(Record):
    """What the sensors of the joints say, each (n,).

    Position (rad or m) and velocity by the encoders; effort (N m or N): what the motors give at the measured currents,
    torque constant times gear ratio times current.
    """

    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class JointCommand(Record):
    """Reference of the joint servos: position, velocity, acceleration, each (n,)."""

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class JointTruth(Record):
    """True joint positions (rad or m), velocities and torques behind the gear (N m or N), each (n,)."""

    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class EncoderCounts(Record):
    """Counts of the axes' encoders since the start, (n,) integers, turns counted on."""

    count: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class DriveState(Record):
    """Motor side of the axes: measured armature current (A) and commanded voltage (V), each (n,)."""

    current: Array
    voltage: Array


@dataclass(frozen=True, slots=True)
class DriveTruth(Record):
    """True armature currents (A), (n,)."""

    current: Array


@dataclass(frozen=True, slots=True)
class BaseState(Record):
    """Where a mobile base believes to be.

    Pose (3,): x, y, theta of base_link in odom; its `covariance` (3, 3); twist (3,): vx, vy, w in base_link.
    """

    pose: Array
    twist: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class BaseCommand(Record):
    """Reference of a mobile base: pose (3,) in odom and twist (3,) in base_link."""

    pose: Array
    twist: Array


@dataclass(frozen=True, slots=True)
class BaseTruth(Record):
    """True pose (3,) of base_link in the world and twist (3,) in base_link."""

    pose: Array
    twist: Array


@dataclass(frozen=True, slots=True)
class Inertial(Record):
    """What a gyro and accelerometers on base_link measure: turning rate (rad/s) about z, acceleration (2,) m/s2."""

    rate: float
    acceleration: Array


@dataclass(frozen=True, slots=True)
class WheelContact(Record):
    """Wheels on the ground, each (n,).

    Driving force (N) and slip, the rim's speed over the ground (m/s), both true; the measured rim speed that no twist
    explains (m/s), an estimate.
    """

    force: Array
    slip: Array
    residual: Array


@dataclass(frozen=True, slots=True)
class WheelLoad(Record):
    """True loads of all wheels that stand on the ground, (n,) N: driven wheels, then the others."""

    load: Array


@dataclass(frozen=True, slots=True)
class Pitch(Record):
    """A body that balances, (1,) rad forwards each: how it leans, and how its controller believes it to."""

    angle: Array
    seen: Array


@dataclass(frozen=True, slots=True)
class Steering(Record):
    """Steered wheels, (k,) rad against their rest each: angles by their encoders, angles asked of their motors."""

    angle: Array
    asked: Array


@dataclass(frozen=True, slots=True)
class FramePoses(Record):
    """True world poses of named frames: `poses` (k, 4, 4), T_wx for x in `names`."""

    names: tuple[str, ...]
    poses: Array


@dataclass(frozen=True, slots=True)
class FrameTree(Record):
    """Frames as the controller believes them, each in its parent: `poses` (k, 4, 4), T_px for each parent and name."""

    parents: tuple[str, ...]
    names: tuple[str, ...]
    poses: Array


@dataclass(frozen=True, slots=True)
class FixedFrames(FrameTree):
    """Frames that never move in their parents."""


@dataclass(frozen=True, slots=True)
class RobotDescription(Record):
    """A robot as URDF; its links are called as frames are, its joints as those of the joint states."""

    text: str


@dataclass(frozen=True, slots=True)
class Photograph(Record):
    """What a camera took: an image file, and its format ("png")."""

    data: bytes
    format: str


@dataclass(frozen=True, slots=True)
class Marker:
    """A thing to look at, that moves with a frame: a "cylinder" or "cube" of a size (m), its middle at T_fm (4, 4)."""

    frame: str
    shape: str
    pose: Array
    size: tuple[float, float, float]
    colour: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Markers(Record):
    """Things to look at, named by their frames."""

    markers: tuple[Marker, ...]


@dataclass(frozen=True, slots=True)
class Reading(Record):
    """What a sensor of a cell measures: its name, and numbers (k,) in its own units."""

    sensor: str
    values: Array


@dataclass(frozen=True, slots=True)
class Signal(Record):
    """A digital signal that changed."""

    number: int
    on: bool


@dataclass(frozen=True, slots=True)
class Event(Record):
    """A line in the log. `level`: "debug", "info", "warning" or "error"; `line` of the program in the file `file`."""

    level: str
    source: str
    text: str
    line: int = 0
    file: str = ""


class Sink(Protocol):
    """Takes records as they come: the recorder, the studio, a test."""

    def put(self, record: Record) -> None:
        """Take one record; `record.time` never decreases within one kind."""
