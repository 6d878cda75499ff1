"""What a program may ask of a robot: the `Machine` protocol and the records that cross it (SI, radians)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, Protocol

from holonom.arrays import Array

__all__ = ["Array", "Configuration", "Machine", "Motion", "MotionKind", "Part", "Tolerance"]


@dataclass(frozen=True, slots=True)
class Configuration:
    """Wanted branch of the inverse geometry; None keeps the present one.

    `shoulder`: "lefty" or "righty"; `elbow`: "above" or "below"; `wrist`: "flip" or "noflip".
    """

    shoulder: str | None = None
    elbow: str | None = None
    wrist: str | None = None


MotionKind = Literal["joint", "line"]
Tolerance = Literal["coarse", "fine"]


@dataclass(frozen=True, slots=True)
class Motion:
    """One motion to a pose or to joint values: exactly one of `pose` and `joints` is given.

    Attributes
    ----------
    kind : {"joint", "line"}
        Joint-interpolated, or the tool point on a straight line.
    pose : (4, 4) array or None
        T_wt, the machine's tool point in the world, m.
    joints : (n,) array or None
        Joint values, rad or m.
    speed : float
        Fraction 0..1 of full joint speed (`kind` joint) or of the nominal straight-line speed.
    speed_mps : float or None
        Absolute tool speed in m/s; takes the place of `speed` where it is given.
    acceleration : float
        Fraction 0..1 of the full acceleration.
    configuration : Configuration
        Branch to end in.
    blend : bool
        Continuous path into the next motion; False: come to rest and settle.
    tolerance : {"coarse", "fine"}
        How closely to settle at the end.
    line : int
        Source line that asked for it.
    """

    kind: MotionKind
    pose: Array | None
    joints: Array | None
    speed: float
    speed_mps: float | None
    acceleration: float
    configuration: Configuration
    blend: bool
    tolerance: Tolerance
    line: int

    def to(self, pose: Array) -> Motion:
        """Return the same motion to another pose (4, 4)."""
        return replace(self, pose=pose)


@dataclass(frozen=True, slots=True)
class Part:
    """A part that the camera found.

    `pose`: (4, 4) T_wp, the tool pose that grasps it. `features`: found (1.0), x (m), y (m), angle (rad),
    area (m2), equal-area diameter (m), then whatever else the camera measures.
    """

    kind: str
    pose: Array
    features: tuple[float, ...]


class Machine(Protocol):
    """A robot, simulated, dry, recorded or real. Nothing here blocks: the program asks again next tick."""

    def move(self, motion: Motion) -> bool:
        """Take a motion: True when taken, False when the queue is full; `MotionError` if it cannot be made."""

    def idle(self) -> bool:
        """Whether all motions have ended and settled."""

    def set_hand(self, closed: bool) -> None:
        """Close or open the hand."""

    def hand_idle(self) -> bool:
        """Whether the hand has ended its last motion."""

    def set_signal(self, number: int, on: bool) -> None:
        """Switch a digital output."""

    def signal(self, number: int) -> bool:
        """Read a digital signal."""

    def picture(self) -> int:
        """Take a picture; return the number of parts seen."""

    def locate(self, kind: str) -> Part | None:
        """Return the next part of this kind ("" for any) of the last picture that was not yet located."""

    def turns(self) -> tuple[bool, ...]:
        """Return of each joint whether it turns; the others slide."""

    def destination(self) -> Array:
        """Return T_wt (4, 4) where the last commanded motion ends."""

    def goal(self) -> Array:
        """Return the joint values (n,), rad or m, where the last commanded motion ends."""

    def joints(self) -> Array:
        """Return the measured joint values (n,), rad or m."""

    def pose(self) -> Array:
        """Return T_wt (4, 4) by the measured joint values."""

    def ready_joints(self) -> Array:
        """Return the joint values (n,) of the READY position."""

    def time(self) -> float:
        """Return the time of the machine's clock, s."""

    def say(self, text: str, line: int) -> None:
        """Show a line of text that TYPE made at this source line."""
