"""`ArmRig`: an arm that runs its program."""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from holonom.app.job import ArmJob
from holonom.app.rig.watch import Watch
from holonom.arrays import Array
from holonom.closed_loop import ArmLoop, IdealArm, SimulatedArm
from holonom.closed_loop.arm import Frame
from holonom.errors import ContactFault
from holonom.lang import Status, start, step
from holonom.machine import ControlSettings
from holonom.machine.digital import DigitalSignals
from holonom.machine.supervisor import StopCategory
from holonom.signals import Sink
from holonom.sim import Fingers, World

__all__ = ["ArmRig", "ArmTruth", "make_loop"]


class ArmTruth(NamedTuple):
    """What is so of an arm: time (s), joints and their speeds and torques (n,), tool pose T_wt (4, 4)."""

    time: float
    position: Array
    speed: Array
    effort: Array
    tool: Array


def make_loop(job: ArmJob, settings: ControlSettings) -> ArmLoop | IdealArm:
    """Return the arm with its drives, standing at home."""
    if job.drives == "ideal":
        return IdealArm(job.arm, job.home, settings)
    return ArmLoop(job.arm, job.home, settings, job.ground)


class ArmRig:
    """An arm with its program.

    Parameters
    ----------
    job
        What it is and does.
    loop
        It with its drives, standing at home.
    world, sink, signals
        What its hand can touch, where its records go, the cell's signals.
    seed
        Of the program's random numbers.
    longest
        Longest time that one of its motions may take, s.
    believed, true
        T (4, 4) of its base where another robot carries it.
    """

    def __init__(
        self,
        job: ArmJob,
        loop: ArmLoop | IdealArm,
        world: World,
        sink: Sink,
        signals: DigitalSignals,
        *,
        seed: int,
        longest: float = inf,
        believed: Frame | None = None,
        true: Frame | None = None,
    ) -> None:
        self.job, self.name, self.loop = job, job.name, loop
        fingers = Fingers(world, job.gripper) if job.gripper is not None else None
        self.arm = SimulatedArm(
            loop,
            fingers,
            sink,
            look=lambda: job.look,
            ready=job.home,
            line=job.line,
            longest=longest,
            believed=believed,
            true=true,
            steady=job.steady,
            signals=signals,
            world=world,
            patience=job.settle_time,
        )
        self._watch = Watch(self.arm, job.contact_force, lambda source, text: self.log("warning", source, text))
        self.machine = self.arm.machine
        for text in loop.warnings:
            self.log("warning", "servos", text)
        self._state = None
        self._status = Status.HALTED
        if job.program is not None:
            self._state = start(job.program, entry=job.entry, rng=np.random.default_rng(seed))
            self._status = Status.RUNNING
        self._line, self._stopping = 0, False

    @property
    def done(self) -> bool:
        """Whether its program has ended or stands at PAUSE, and the arm and its hand too."""
        ended = self._status in (Status.HALTED, Status.PAUSED) and self.loop.time >= self.job.hold - 1e-9
        return ended and self.machine.idle() and self.machine.hand_idle()

    @property
    def paused(self) -> bool:
        """Whether its program stands at PAUSE."""
        return self._status is Status.PAUSED

    @property
    def standing(self) -> bool:
        """Whether a stop has come to its end."""
        return self.machine.stopped

    @property
    def truth(self) -> ArmTruth:
        """What sensors of the cell may see of it."""
        true = self.loop.truth
        return ArmTruth(self.loop.time, true.position, true.speed, true.effort, self.arm.tool_pose())

    def think(self) -> None:
        """One step of its program."""
        if self._state is None or self.job.program is None:
            return
        self._status = step(self.job.program, self._state, self.machine)
        if self.machine.active_line not in (0, self._line):
            self._line = self.machine.active_line
            text = self.job.program.source(self._line).split(";")[0].strip()
            self.machine.log("debug", "program", text, self._line)

    def advance(self, ticks: int) -> None:
        """Advance by some ticks; faults as `ArmMachine.advance`, and `ContactFault`."""
        for _ in range(ticks):
            self.machine.advance()
            if not self._stopping:
                self._watch.look()

    def begin_stop(self, category: StopCategory) -> None:
        """Stop from the next tick on: along the path, or with the drives at zero speed."""
        self._stopping = True
        if category is StopCategory.ON_PATH:
            self.machine.begin_halt()
        else:
            self.machine.begin_brake()

    def explain(self, fault: Exception) -> str:
        """Word a fault, with the program line whose motion it stopped, or at which it stood."""
        program, line = self.job.program, self.machine.active_line
        if line == 0:
            line = self.machine.last_line if isinstance(fault, ContactFault) else self._waits_at
        if program is None or line == 0 or str(fault).startswith(f"{program.file}:"):
            return str(fault)
        return f"{program.file}:{line}: {fault}\n  {line} | {program.source(line)}"

    @property
    def _waits_at(self) -> int:
        """The program's line at which it waits for the arm, 0 where it does not."""
        return self._state.line if self._state is not None and self._status is Status.WAITING else 0

    def log(self, level: str, source: str, text: str) -> None:
        """Record an event of it."""
        self.machine.log(level, source, text, self.machine.active_line)

    def where(self) -> str:
        """The program line that is under way, as a place in its file, and what it waits for; "" without one."""
        program, state = self.job.program, self._state
        if program is None or state is None:
            return ""
        waits = self.machine.unsettled()
        return f"{program.file}:{state.line}: {program.source(state.line).strip()}{f' ({waits})' if waits else ''}"
