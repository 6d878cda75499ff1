"""What a cell is once it is read: the parts of a run, in SI and as domain objects; nothing of the file is left."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from holonom.app.report import PhotoOverlay, Scene
from holonom.arrays import Array
from holonom.geometry import Shape
from holonom.lang import Part, Program
from holonom.machine import BaseSettings, ControlSettings, Levels, LineSettings, ReferencePath
from holonom.mechanics import Arm
from holonom.mobile import BaseDrive, BaseSensors, WheelBase
from holonom.mobile.base.payload import Payload
from holonom.sim import BaseFault, Disc, Floor, Gripper, Ground, Surface

__all__ = [
    "ArmJob",
    "BaseJob",
    "FieldPlace",
    "Job",
    "Mount",
    "Obstacle",
    "PathTolerance",
    "SensorJob",
    "SignalEvent",
    "Task",
]


@dataclass(frozen=True, slots=True)
class Mount:
    """Where a robot stands: in the world, or on a frame of another robot; T (4, 4) from there to its own origin."""

    T: Array
    robot: str | None = None
    frame: str = "base_link"


@dataclass(frozen=True, slots=True)
class ArmJob:
    """An arm and what it is to do.

    Attributes
    ----------
    name
        "" for the only robot of a short form.
    arm
        With tool, load and limits; on its base where it stands in the world, at the origin where it is mounted.
    mount
        None where `arm` stands on its own base already.
    drives
        "motors" (stated), "from_limits" (sized): the arm's model has them; "ideal": joints follow within limits.
    settings
        One for each controller under which the program runs; all but the last for comparison.
    home
        Joints (n,), rad or m.
    program, entry, hold
        Without a program it stands, for some time (s).
    steady
        Whether its tool stays in the world, between its motions, while the base that carries it moves.
    look
        The parts that its camera sees.
    rated
        The arm as its model states it, where the cell keeps below its limits.
    gripper, ground, line
        Its hand, what lies under its tool, what 100 % means on lines.
    contact_force, settle_time
        Force (N) above which it is stopped; how long (s) a program waits for it to settle.
    """

    name: str
    arm: Arm
    mount: Mount | None
    drives: str
    settings: tuple[ControlSettings, ...]
    home: Array
    program: Program | None
    entry: str | None
    look: tuple[Part, ...]
    gripper: Gripper | None
    ground: Ground
    line: LineSettings
    rated: Arm
    hold: float = 0.0
    steady: bool = False
    contact_force: float = 150.0
    settle_time: float = 5.0


@dataclass(frozen=True, slots=True)
class PathTolerance:
    """How far from its path a base may be: position, m, and heading, rad."""

    position: float
    heading: float


@dataclass(frozen=True, slots=True)
class Task:
    """What a base is to do: one of a path, velocities (rows time, vx, vy, w from its start on) and holding (s).

    It begins at `start` (s), or when signal `after` goes on; at its end signal `done` is switched on. A path without a
    tolerance is not judged.
    """

    path: ReferencePath | None = None
    tolerance: PathTolerance | None = None
    velocities: Array | None = None
    hold: float | None = None
    start: float = 0.0
    after: int | None = None
    done: int | None = None

    @property
    def end(self) -> float:
        """When it ends if all goes well, s; where it waits for a signal, how long it takes from then on."""
        way = self.hold or 0.0
        if self.path is not None:
            way = float(self.path.time[-1])
        elif self.velocities is not None:
            way = float(self.velocities[-1, 0])
        return self.start + way


@dataclass(frozen=True, slots=True)
class BaseJob:
    """A mobile base and what it is to do.

    `drives` is "motors", "from_limits" or "ideal"; `pose` (3,) x, y, theta is where it starts; `sensors` are its
    inertial sensors as they err, and are known to; `frames` are T (4, 4) of the frames that other robots stand on;
    `levels` say how often points of its path come; `lean` is the pitch (rad) at which a body that balances starts;
    `payloads` are what it carries from a time (s) on, in their order.
    """

    name: str
    base: WheelBase
    drive: BaseDrive
    drives: str
    settings: BaseSettings
    sensors: BaseSensors
    pose: Array
    task: Task
    faults: tuple[BaseFault, ...]
    frames: Mapping[str, Array]
    levels: Levels = field(default_factory=Levels)
    lean: float = 0.0
    payloads: tuple[tuple[float, Payload], ...] = ()


@dataclass(frozen=True, slots=True)
class SensorJob:
    """A sensor that is read at each record: `make` of its method gave `sensor`; on which robot; what it is called."""

    name: str
    robot: str
    kind: str
    sensor: Any


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Something that nothing may hit: T (4, 4) of its middle, and its shape, which stands upright."""

    name: str
    T: Array
    shape: Shape


@dataclass(frozen=True, slots=True)
class FieldPlace:
    """A field of a tray: T (4, 4) of its corner, extent along x and y (m), height below which parts lie in it."""

    name: str
    T: Array
    size: tuple[float, float]
    height: float


@dataclass(frozen=True, slots=True)
class SignalEvent:
    """A signal that is switched at a time, s."""

    at: float
    number: int
    on: bool


@dataclass(frozen=True, slots=True)
class Job:
    """All that a run needs.

    `patches` are the names of the floor's patches; `fields` are where parts are to go; `scene` and `photograph` are
    what the report shows; `notes` are sentences about
    what was assumed, for check, summary and report; `unreachable` are taught locations that no arm can go to.
    """

    name: str
    description: str
    file: Path
    seed: int
    time_limit: float
    arms: tuple[ArmJob, ...] = ()
    bases: tuple[BaseJob, ...] = ()
    floor: Floor = field(default_factory=Floor)
    surfaces: tuple[Surface, ...] = ()
    parts: tuple[Disc, ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    sensors: tuple[SensorJob, ...] = ()
    events: tuple[SignalEvent, ...] = ()
    patches: tuple[str, ...] = ()
    fields: tuple[FieldPlace, ...] = ()
    scene: Scene = field(default_factory=lambda: Scene((), ()))
    photograph: PhotoOverlay | None = None
    notes: tuple[str, ...] = ()
    unreachable: tuple[str, ...] = ()
