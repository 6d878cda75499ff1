"""Everything about a running program that changes: plain data that can be copied and run again."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from holonom.errors import ProgramFault
from holonom.lang.machine import Array, Configuration, Machine, Part, Tolerance
from holonom.lang.program import Program, Routine, Value
from holonom.lang.vm.formats import shown

__all__ = ["Frame", "Settings", "Speed", "Status", "Variable", "Vm", "VmState"]

_LARGEST_INDEX = 32767


class Status(StrEnum):
    """What a program is doing."""

    RUNNING = "running"
    WAITING = "waiting"
    PAUSED = "paused"
    HALTED = "halted"


@dataclass(slots=True)
class Variable:
    """A variable: its value, or its elements by their indices. Passing it by reference is passing it."""

    name: str
    value: Value | None = None
    elements: dict[tuple[int, ...], Variable] = field(default_factory=dict)

    def read(self) -> Value:
        """Return the value; `ProgramFault` when it has none."""
        if self.value is None:
            raise ProgramFault(f"{self.name!r} has no value yet; assign it before it is used")
        return self.value

    @property
    def defined(self) -> bool:
        """Whether it, or one of its elements, has a value."""
        return self.value is not None or any(part.defined for part in self.elements.values())

    def element(self, indices: tuple[Value, ...]) -> Variable:
        """Return the element at these indices, whole numbers from 0 to 32767; a new one has no value."""
        key = tuple(self._index(i) for i in indices)
        if key not in self.elements:
            self.elements[key] = Variable(f"{self.name}[{', '.join(map(str, key))}]")
        return self.elements[key]

    def _index(self, value: Value) -> int:
        number = float(value)
        if not (0 <= number <= _LARGEST_INDEX and number.is_integer()):
            raise ProgramFault(
                f"index {shown(number)} of {self.name!r} is out of range; it must be whole, 0 to {_LARGEST_INDEX}"
            )
        return int(number)


@dataclass(slots=True)
class Frame:
    """A routine under way: which one, its next operation, its own variables, the line that called it."""

    routine: int
    pc: int
    variables: list[Variable]
    called_from: int


@dataclass(frozen=True, slots=True)
class Speed:
    """Speed of motions: `fraction` 0..1 of the full one; `mps` in m/s for straight lines where given."""

    fraction: float = 1.0
    mps: float | None = None


@dataclass(slots=True)
class Settings:
    """What motion instructions take along; `next_...` hold for one motion only.

    `base` and `tool`, (4, 4): a location P is reached with T_wt = base @ P @ inverse(tool).
    """

    speed: Speed = Speed()
    next_speed: Speed | None = None
    monitor: float = 1.0
    acceleration: float = 1.0
    configuration: Configuration = field(default_factory=Configuration)
    continuous: bool = True
    tolerance: Tolerance = "fine"
    next_tolerance: Tolerance | None = None
    base: Array = field(default_factory=lambda: np.eye(4))
    tool: Array = field(default_factory=lambda: np.eye(4))


@dataclass(slots=True)
class VmState:
    """The whole state of a program under way. `copy()` is a snapshot: a run from it goes the same way.

    Attributes
    ----------
    globals : list of Variable
        Variables of the program, in the order of `Program.globals`.
    frames : list of Frame
        Routines under way, the innermost last.
    random : numpy.random.Generator
        What RANDOM draws from.
    status, line
        What the program is doing and the source line it is at.
    settings : Settings
        Speed, configuration, tool, ...
    stack : list
        Operands of the operation under way.
    phase, until
        Progress of an instruction that takes several ticks; end of a DELAY, s.
    busy_ticks : int
        Ticks in a row that ended without a motion or a wait.
    timers : dict
        Machine time at which each TIMER read 0, s.
    outputs : set of int
        Signals this program has switched on.
    part, parts
        The part that VLOCATE found last; how many the last picture showed.
    typed : str
        What TYPE with /S has begun and not ended.
    """

    globals: list[Variable]
    frames: list[Frame]
    random: np.random.Generator
    status: Status = Status.RUNNING
    line: int = 0
    settings: Settings = field(default_factory=Settings)
    stack: list[Value | Variable] = field(default_factory=list)
    phase: int = 0
    until: float = 0.0
    busy_ticks: int = 0
    timers: dict[int, float] = field(default_factory=dict)
    outputs: set[int] = field(default_factory=set)
    part: Part | None = None
    parts: int = 0
    typed: str = ""

    def copy(self) -> VmState:
        """Return an independent state; variables shared by reference stay shared within the copy."""
        return copy.deepcopy(self)


@dataclass(slots=True)
class Vm:
    """What an instruction sees while it runs: the program, its state, the machine."""

    program: Program
    state: VmState
    machine: Machine

    @property
    def frame(self) -> Frame:
        """The routine under way."""
        return self.state.frames[-1]

    @property
    def routine(self) -> Routine:
        """The code of the routine under way."""
        return self.program.routines[self.frame.routine]
