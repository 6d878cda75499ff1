"""A program of a cell, run dry: every motion planned, nothing moved; what other robots give is taken as given."""

from __future__ import annotations

import copy
import math
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from holonom.app.cell.surroundings import Reach, Surroundings
from holonom.app.job import ArmJob, BaseJob, Job
from holonom.arrays import Array
from holonom.errors import MotionError, ProgramFault
from holonom.lang import Program, Status, VmState, start, step
from holonom.machine import DryMachine, Problem
from holonom.machine.arm.motions import MotionRequest
from holonom.machine.group import planar_pose
from holonom.mechanics.motion import Trajectory
from holonom.sim import Fingers, World
from holonom.spatial import inverse

__all__ = ["Rehearsal", "end_of", "rehearse", "switches_signals"]

SETTLE = 1.0
"""Time, s, in which fingers arrive and parts fall."""
TOUCH = 2e-3
"""Depth, m, up to which ideal joints may be inside a surface."""
PATIENCE = 3
"""Times that a program asks for a signal, without moving in between, before another robot is taken to have given it."""


@dataclass(frozen=True, slots=True)
class Rehearsal:
    """The machine at the end, with the motions that it could not plan; what else ended the program; notes."""

    machine: DryMachine
    failures: tuple[str, ...]
    notes: tuple[str, ...]

    def problems(self, program: Program) -> list[str]:
        """Motions that cannot be made, or run into something: each line of the program once, with the first reason."""
        return self._by_line(program, self.machine.problems)

    def warnings(self, program: Program) -> list[str]:
        """Motions that press on something no harder than the cell allows: each line of the program once."""
        return self._by_line(program, self.machine.warnings)

    @staticmethod
    def _by_line(program: Program, found: Sequence[Problem]) -> list[str]:
        times = Counter(problem.line for problem in found)
        first = {problem.line: problem.text for problem in reversed(found)}
        return [
            f"{program.file}:{line}: {first[line]}{f' ({times[line]} times)' if times[line] > 1 else ''}"
            for line in sorted(first)
        ]


def rehearse(job: Job, arm: ArmJob, *, progress: Callable[[float], None] = lambda time: None) -> Rehearsal:
    """Run the program of one of a job's arms without dynamics, on the parts that the camera sees.

    Signals are switched by the program itself and by events at their times. One that another robot may give is taken
    as given where the program waits for it, and a base that gives it as arrived. `progress` is told the simulated time.
    """
    program = arm.program
    assert program is not None
    machine = _Rehearsed(job, arm)
    state = start(program, entry=arm.entry, rng=np.random.default_rng(job.seed))
    try:
        while (status := step(program, state, machine)) not in (Status.HALTED, Status.PAUSED):
            if status is Status.WAITING and not machine.give(state.line):
                machine.pass_until(min(_nothing_until(program, state, machine), job.time_limit))
            machine.tick()
            progress(machine.time())
            if machine.time() >= job.time_limit:
                limit = f"not done after {job.time_limit:g} s, the cell's time_limit"
                return Rehearsal(machine, (f"{program.file}:{state.line}: {limit}",), tuple(machine.notes))
    except ProgramFault as fault:
        return Rehearsal(machine, (str(fault),), tuple(machine.notes))
    return Rehearsal(machine, (), tuple(machine.notes))


def _nothing_until(program: Program, state: VmState, machine: _Rehearsed) -> float:
    """When what a program waits for may change, s: at the end of a DELAY, or at the next event of a signal."""
    frame = state.frames[-1]
    code, operand, _ = program.routines[frame.routine].code[frame.pc]
    word = operand[0] if code == "ACTION" and isinstance(operand, tuple) else None
    if word == "DELAY" and state.phase == 1:
        return state.until
    if word == "WAIT.SIGNAL" and machine.asked_in_vain:
        return machine.next_event()
    return machine.time()


class _Rehearsed(DryMachine):
    """A dry machine among other robots: their signals, and the base that carries it."""

    def __init__(self, job: Job, arm: ArmJob) -> None:
        hand = arm.gripper
        super().__init__(
            arm.arm,
            arm.home,
            look=lambda: arm.look,
            ready=arm.home,
            line=arm.line,
            hand_time=hand.max_opening / hand.speed if hand is not None else 0.0,
            longest=job.time_limit,
        )
        self.notes: list[str] = []
        world = World(job.surfaces, [copy.copy(part) for part in job.parts])
        self._fingers = Fingers(world, hand) if hand is not None else None
        self._surroundings = Surroundings(arm.arm, hand, world, job.obstacles)
        self._deepest = TOUCH if arm.drives == "ideal" else arm.contact_force / arm.ground.stiffness
        self._force = arm.ground.stiffness
        self._events = sorted(job.events, key=lambda event: event.at)
        self._givers = {base.task.done: base for base in job.bases if base.task.done is not None}
        self._others = any(other is not arm and switches_signals(other.program) for other in job.arms)
        self._given: dict[int, bool] = {}
        self._asked: Counter[int] = Counter()
        self._bases = {base.name: base for base in job.bases}
        self._mount = arm.mount
        self._frame = self._carried({})

    def _carried(self, arrived: Mapping[str, Array]) -> Array:
        """T (4, 4) of its own base in the world, where another robot carries it."""
        if self._mount is None or self._mount.robot is None:
            return np.eye(4)
        base = self._bases[self._mount.robot]
        on_base = base.frames[self._mount.frame] @ self._mount.T
        found: Array = planar_pose(arrived.get(base.name, base.pose)) @ on_base
        return found

    def move(self, motion: MotionRequest) -> bool:
        """Plan a motion, a goal in the world from where its base stands; see `DryMachine.move`."""
        if self._mount is not None and motion.pose is not None:
            motion = motion.to(inverse(self._frame) @ motion.pose)
        moved = super().move(motion)
        if moved:
            self._asked.clear()
        return moved

    def pose(self) -> Array:
        """T_wt (4, 4)."""
        T = super().pose()
        return T if self._mount is None else self._frame @ T

    def destination(self) -> Array:
        """T_wt (4, 4) where the last motion ended."""
        return self.pose()

    def set_hand(self, closed: bool) -> None:
        """Close or open the hand; `MotionError` without one."""
        fingers = self._fingers
        if fingers is None:
            raise MotionError("this arm has no hand to close or open; give its cell a [gripper]")
        super().set_hand(closed)
        fingers.send(0.0 if closed else fingers.gripper.max_opening)
        for _ in range(2):  # the fingers move, then what they let go falls
            with suppress(MotionError):  # a finger on a part: where parts truly lie only a run shows
                fingers.step(self.pose(), SETTLE)

    def look_at(self, trajectory: Trajectory) -> tuple[str | None, str | None]:
        """Say where a motion runs into something; a surface that it presses on lightly is a warning."""
        found = self._surroundings.met_by(trajectory, self._frame, self._reach())
        if found is None:
            return None, None
        if found.depth > self._deepest:
            return found.text, None
        return None, f"{found.text}, which presses on it with about {found.depth * self._force:.0f} N"

    def around(self) -> tuple[Hashable, ...]:
        """What the hand does, and where the base stands."""
        return (*(round(v, 6) for v in self._reach()), self._frame.tobytes())

    def _reach(self) -> Reach:
        return Reach() if self._fingers is None else Reach(self._fingers.opening, self._fingers.hang)

    def set_signal(self, number: int, on: bool) -> None:
        """Switch a signal."""
        self._given.pop(number, None)
        super().set_signal(number, on)

    def signal(self, number: int) -> bool:
        """Read a signal: as it was switched last, by the program, by an event or by who is taken to have done so."""
        self._asked[number] += 1
        if number in self._given:
            return self._given[number]
        past = [event.on for event in self._events if event.number == number and event.at <= self.time()]
        return past[-1] if past else super().signal(number)

    @property
    def asked_in_vain(self) -> bool:
        """Whether the program has asked for signals so often that nobody but an event will give them."""
        return bool(self._asked) and min(self._asked.values()) >= PATIENCE

    def next_event(self) -> float:
        """When the next signal of the cell is switched, s; infinity where none is."""
        return min((event.at for event in self._events if event.at > self.time()), default=math.inf)

    def give(self, line: int) -> bool:
        """Take a signal as given for which the program has asked some times where another robot may give it."""
        given = False
        for number, times in list(self._asked.items()):
            if times < PATIENCE or self._comes(number):
                continue
            giver = self._givers.get(number)
            if giver is None and not self._others:
                continue
            who = f"robot {giver.name!r}" if giver is not None else "another arm's program"
            self.notes.append(f"it waits for signal {number} at line {line}; taken as given by {who}")
            self._given[number], given = not self.signal(number), True
            if giver is not None:
                self._frame = self._carried({giver.name: end_of(giver)})
            self._asked.clear()
        return given

    def _comes(self, number: int) -> bool:
        return any(event.number == number and event.at > self.time() for event in self._events)


def switches_signals(program: Program | None) -> bool:
    """Return whether a program switches signals."""
    routines = program.routines if program is not None else ()
    return any(
        code == "ACTION" and isinstance(operand, tuple) and operand[0] == "SIGNAL"
        for routine in routines
        for code, operand, _ in routine.code
    )


def end_of(base: BaseJob) -> Array:
    """Where the task of a base ends, if all goes well: pose (3,)."""
    task = base.task
    if task.path is not None:
        return task.path.pose[-1]
    if task.velocities is None:
        return base.pose
    T, rows = planar_pose(base.pose), task.velocities
    for row, until in zip(rows[:-1], rows[1:, 0], strict=True):
        T = T @ _moved(row[1:], float(until - row[0]))
    return np.array([T[0, 3], T[1, 3], np.arctan2(T[1, 0], T[0, 0])])


def _moved(twist: Array, time: float) -> Array:
    """Displacement (4, 4) of a constant twist (3,) after a time (s): an arc."""
    vx, vy, w = twist
    angle = w * time
    s, c = (time, 0.0) if abs(angle) < 1e-9 else (np.sin(angle) / w, (1.0 - np.cos(angle)) / w)
    return planar_pose((vx * s - vy * c, vx * c + vy * s, angle))
