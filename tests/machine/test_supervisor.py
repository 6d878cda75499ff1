"""The supervisor: all robots stop together, each as its fault asks for, and never softer than before."""

from __future__ import annotations

import pytest

from holonom.errors import ContactFault, DriveFault, LevelFault, MotionError, ProgramFault, RunError
from holonom.machine.supervisor import StopCategory, Supervision, Supervisor


class Robot:
    """It takes some ticks to stand."""

    def __init__(self, name: str, ticks: int) -> None:
        self.name, self.left, self.told = name, ticks, []

    @property
    def standing(self) -> bool:
        self.left -= 1 if self.told else 0
        return self.left <= 0

    def begin_stop(self, category: StopCategory) -> None:
        self.told.append(category)


@pytest.mark.parametrize(
    ("fault", "category"),
    [
        (DriveFault("x"), StopCategory.ZERO_SPEED),
        (ContactFault("x"), StopCategory.ZERO_SPEED),
        (LevelFault("x"), StopCategory.ZERO_SPEED),
        (MotionError("x"), StopCategory.ON_PATH),
        (ProgramFault("x"), StopCategory.ON_PATH),
        (RunError("x"), StopCategory.ON_PATH),
    ],
)
def test_each_fault_has_its_category(fault: RunError, category: StopCategory) -> None:
    robots = [Robot("a", 1), Robot("b", 3)]
    supervisor = Supervisor(robots)
    assert supervisor.tick() is Supervision.RUNNING
    supervisor.fail(robots[0], fault)
    assert robots[0].told == [category]
    assert robots[1].told == [StopCategory.ON_PATH]
    assert supervisor.fault is fault
    states = [supervisor.tick() for _ in range(3)]
    assert states == [Supervision.STOPPING, Supervision.STOPPING, Supervision.STOPPED]


def test_a_stop_gets_harder_never_softer() -> None:
    robot = Robot("", 5)
    supervisor = Supervisor([robot])
    supervisor.stop()
    assert supervisor.fault is None
    supervisor.fail(robot, DriveFault("first"))
    supervisor.fail(robot, MotionError("second"))
    supervisor.stop(StopCategory.ON_PATH)
    assert robot.told == [StopCategory.ON_PATH, StopCategory.ZERO_SPEED]
    assert str(supervisor.fault) == "first"
