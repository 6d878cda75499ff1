"""What a recording says of its run beside what happened: the cell's robots, fields and parts. Data only.

It stands as JSON in the recording: at its beginning `cell.json`, a `CellFacts`, and the words `outcome` at its end, an
`Ending`. All is SI; a limit that there is not, or that nobody knows, is None.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from holonom.devices import DcMotor, Gear
from holonom.mobile import Wheel

__all__ = [
    "ArmFacts",
    "BaseFacts",
    "CellFacts",
    "Ending",
    "FaultFacts",
    "FieldFacts",
    "JointFacts",
    "PartFacts",
    "PatchFacts",
    "RobotFacts",
    "Rows",
]

Rows = tuple[tuple[float, ...], ...]
"""A pose (4, 4), or points (N, 2)."""
Limit = tuple[float | None, ...]
IDEAL = "ideal"
"""Drives without motors."""


@dataclass(frozen=True, slots=True)
class JointFacts:
    """A joint as kinematics has it, see `holonom.model.Joint`: `T = before @ motion(q) @ after`.

    `parent` is the number of the joint that carries it, -1 for the base; `mimic` (joint, factor, offset).
    """

    name: str
    kind: str
    before: Rows
    after: Rows
    parent: int
    mimic: tuple[int, float, float] | None = None


@dataclass(frozen=True, slots=True)
class ArmFacts:
    """An arm's kinematics: base T_w0, its joints, the number of the one that carries the tool, the tool in its frame.

    `fixed` is false where it stands on another robot: the base is none then that stays.
    """

    base: Rows
    joints: tuple[JointFacts, ...]
    tip: int
    tool: Rows
    fixed: bool = True


@dataclass(frozen=True, slots=True)
class FaultFacts:
    """What is to fail of a wheel at `time` (s), one of `sim.base.plant.FAULTS`."""

    time: float
    wheel: str
    kind: str


@dataclass(frozen=True, slots=True)
class PatchFacts:
    """A patch of other floor, or what an obstacle covers of it: corners (N, 2) in the world."""

    name: str
    corners: Rows


@dataclass(frozen=True, slots=True)
class BaseFacts:
    """A mobile base as `holonom.mobile.WheelBase` takes it, its motors, and the floor it drives on.

    `friction` is the floor's largest coefficient, at slip `slip_at_peak`, m/s. The tolerances, m and rad, are what its
    path is judged by; None without.
    """

    wheels: tuple[Wheel, ...]
    radius: float
    alpha: float
    mass: float | None
    com: tuple[float, ...]
    com_height: float
    motor: DcMotor
    gear: Gear
    friction: float
    slip_at_peak: float
    faults: tuple[FaultFacts, ...] = ()
    position_tolerance: float | None = None
    heading_tolerance: float | None = None


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """A robot.

    Attributes
    ----------
    name
        "" for one that is alone.
    kind
        "arm" or "base".
    model, controller, drives
        In words.
    joints
        Names of the joints that move on their own, or of the driven wheels, as recorded.
    kinds
        "revolute" or "prismatic", one for each.
    limits
        For each joint: "speed" (rad/s or m/s), "torque" (N m or N, at the joint), "current" (A), "voltage" (V).
    program
        Name of the attachment that holds its program, "" where it has none.
    """

    name: str
    kind: str
    model: str
    controller: str
    drives: str
    joints: tuple[str, ...]
    kinds: tuple[str, ...]
    limits: Mapping[str, Limit] = field(default_factory=dict)
    program: str = ""
    arm: ArmFacts | None = None
    base: BaseFacts | None = None

    @property
    def ideal(self) -> bool:
        """Whether its drives are: nothing is known then of forces, currents and voltages."""
        return self.drives == IDEAL


@dataclass(frozen=True, slots=True)
class FieldFacts:
    """A field of a tray where parts are to go: T (4, 4) of its corner, extent along x and y, height that counts, m."""

    name: str
    T: Rows
    size: tuple[float, float]
    height: float


@dataclass(frozen=True, slots=True)
class PartFacts:
    """A part: its frame in the recording, and its thickness, m."""

    name: str
    thickness: float


@dataclass(frozen=True, slots=True)
class CellFacts:
    """A cell; `notes` are sentences about what was assumed."""

    title: str
    description: str = ""
    seed: int = 0
    notes: tuple[str, ...] = ()
    robots: tuple[RobotFacts, ...] = ()
    patches: tuple[PatchFacts, ...] = ()
    fields: tuple[FieldFacts, ...] = ()
    parts: tuple[PartFacts, ...] = ()
    obstacles: tuple[PatchFacts, ...] = ()
    steps: tuple[PatchFacts, ...] = ()


Numbers = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Ending:
    """How a run ended.

    Attributes
    ----------
    status
        "done", "paused", "failed", "stopped" (by its operator) or "time limit"; "cut off" of what a killed run left,
        "unknown" of a recording that says nothing.
    reason
        One sentence.
    simulated_time
        s.
    joints
        For each robot by name, and each of its joints or wheels: "peak_speed", "peak_torque", "peak_current",
        "peak_voltage", "peak_error", "rms_error" (rad or m), "peak_grip" (force over what friction can hold), each at
        the rate of the compiled loops; absent where it is not known.
    numbers
        For each robot by name: "path_driven" (0 to 1, of a path with a tolerance the part on which it truly was within
        it), "contact_force" (N), as far as it has them.
    """

    status: str
    reason: str
    simulated_time: float
    joints: Mapping[str, Mapping[str, Numbers]] = field(default_factory=dict)
    numbers: Mapping[str, Numbers] = field(default_factory=dict)
