"""`Supervisor`: faults and stops of all robots of a cell, by the stop categories of IEC 60204-1, 9.2.2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum, IntEnum
from typing import Protocol

from holonom.errors import ContactFault, DriveFault, LevelFault, MotionError, ProgramFault, RunError

__all__ = ["CATEGORIES", "OPERATOR", "StopCategory", "Stoppable", "Supervision", "Supervisor"]


class StopCategory(IntEnum):
    """How robots stop."""

    UNCONTROLLED = 0
    """Power off at once; brakes do the rest."""
    ZERO_SPEED = 1
    """The drives hold zero speed, whatever the path; power off once they stand."""
    ON_PATH = 2
    """Brake along the path, and hold: the drives stay under power."""


CATEGORIES: Mapping[type[RunError], StopCategory] = {
    ContactFault: StopCategory.ZERO_SPEED,
    DriveFault: StopCategory.ZERO_SPEED,
    LevelFault: StopCategory.ZERO_SPEED,
    MotionError: StopCategory.ON_PATH,
    ProgramFault: StopCategory.ON_PATH,
}
"""How a robot stops after a fault; the others of the cell stop on their paths."""
OPERATOR = StopCategory.ON_PATH
"""How robots stop when the operator says so (Ctrl-C, SIGTERM)."""


class Stoppable(Protocol):
    """A robot as its supervisor sees it."""

    @property
    def name(self) -> str:
        """Name, "" for the only one."""

    @property
    def standing(self) -> bool:
        """Whether a stop that was begun has come to its end."""

    def begin_stop(self, category: StopCategory) -> None:
        """Stop from the next tick on."""


class Supervision(Enum):
    """What the cell does."""

    RUNNING = "running"
    STOPPING = "stopping"
    STOPPED = "stopped"


class Supervisor:
    """Stops all robots together once something fails, or the operator says so.

    A second fault during a stop makes it harder, never softer. Mutable state: `state`, the first fault, each robot's
    category.
    """

    def __init__(self, robots: Sequence[Stoppable]) -> None:
        self.robots = tuple(robots)
        self.state = Supervision.RUNNING
        self.fault: RunError | None = None
        """What failed first; None where the operator stopped it."""
        self._categories: dict[str, StopCategory] = {}

    def fail(self, robot: Stoppable | None, fault: RunError, category: StopCategory | None = None) -> None:
        """Take a fault of a robot (None: of the cell) and begin to stop; `category` if not the fault's own."""
        self.fault = self.fault or fault
        own = category
        if own is None:
            own = next((c for kind, c in CATEGORIES.items() if isinstance(fault, kind)), StopCategory.ON_PATH)
        for other in self.robots:
            self._begin(other, own if other is robot else StopCategory.ON_PATH)
        self.state = Supervision.STOPPING

    def stop(self, category: StopCategory = OPERATOR) -> None:
        """Begin to stop all robots."""
        for robot in self.robots:
            self._begin(robot, category)
        self.state = Supervision.STOPPING

    def tick(self) -> Supervision:
        """Return what the cell does, after each tick."""
        if self.state is Supervision.STOPPING and all(robot.standing for robot in self.robots):
            self.state = Supervision.STOPPED
        return self.state

    def _begin(self, robot: Stoppable, category: StopCategory) -> None:
        """A stop that is under way goes on unless this one is harder: categories get softer with their number."""
        before = self._categories.get(robot.name)
        if before is None or category < before:
            self._categories[robot.name] = category
            robot.begin_stop(category)
