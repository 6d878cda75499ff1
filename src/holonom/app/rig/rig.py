"""`Rig`: all robots of a job, advanced together, recorded as they go, stopped together."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence

import numpy as np

from holonom.app.job import ArmJob, Job, Mount
from holonom.app.recording import Recorder
from holonom.app.recording.urdf import BASE
from holonom.app.report.findings.facts import Ending as EndingFacts
from holonom.app.rig.arm import ArmRig, make_loop
from holonom.app.rig.arm_sink import ArmSink
from holonom.app.rig.base import BaseRig, make_base
from holonom.app.rig.collisions import Collisions
from holonom.app.rig.ending import Ended, Ending
from holonom.app.rig.robot import TICK, RobotRig
from holonom.app.rig.stated import put_stated
from holonom.arrays import Array
from holonom.closed_loop import ArmLoop, BaseLoop, IdealArm
from holonom.errors import ContactFault, MotionError, ProgramFault, RunError
from holonom.machine import ControlSettings
from holonom.machine.digital import DigitalSignals
from holonom.machine.group import Group
from holonom.machine.supervisor import StopCategory, Supervision, Supervisor
from holonom.signals import Event, FramePoses, Reading
from holonom.sim import World

__all__ = ["Rig", "Simulated", "simulated"]


LONG = 10
STANDS = 30.0  # s within which robots that are stopped stand, or the run ends without that
"""Ticks that a cell is advanced at once where nothing is decided between them."""


class Simulated:
    """The closed loops of a job's robots, by name, before their first tick."""

    def __init__(self, arms: dict[str, ArmLoop | IdealArm], bases: dict[str, BaseLoop]) -> None:
        self.arms, self.bases = arms, bases

    def warm_up(self) -> None:
        """Compile all that their ticks need, on copies: no time passes for them."""
        for arm in self.arms.values():
            trial = copy.deepcopy(arm)
            trial.advance(np.stack([trial.position[None], np.zeros((1, trial.arm.n)), np.zeros((1, trial.arm.n))]))
        for base in self.bases.values():
            trial_base = copy.deepcopy(base)
            trial_base.advance_logged(trial_base.buffer(1))


def simulated(job: Job, settings: Sequence[ControlSettings]) -> Simulated:
    """Make the closed loops of a job; `settings` are those of each arm."""
    rngs = [np.random.default_rng(job.seed)]
    if len(job.bases) > 1:
        rngs = [np.random.default_rng(s) for s in np.random.SeedSequence(job.seed).spawn(len(job.bases))]
    arms = {a.name: make_loop(a, own) for a, own in zip(job.arms, settings, strict=True)}
    bases = {b.name: make_base(b, job.floor, rng) for b, rng in zip(job.bases, rngs, strict=False)}
    return Simulated(arms, bases)


class Rig:
    """A job in motion.

    Parameters
    ----------
    job
        What is there and what is to be done.
    loops
        Its robots; they are advanced.
    recorder
        Where all goes.
    say
        Takes what programs type.
    """

    def __init__(self, job: Job, loops: Simulated, recorder: Recorder, *, say: Callable[[str], None]) -> None:
        self.job, self._recorder = job, recorder
        self.world = World(job.surfaces, [copy.copy(part) for part in job.parts])
        self.signals = DigitalSignals(recorder)
        self.robots: list[RobotRig] = []
        self.bases: dict[str, BaseRig] = {}
        self.arms: dict[str, ArmRig] = {}
        alone = len(job.arms) + len(job.bases) == 1
        for base in job.bases:
            sink = recorder.scoped(base.name, base.base.driven, tool="base_link")
            self.bases[base.name] = BaseRig(base, loops.bases[base.name], job.floor, sink, self.signals, alone=alone)
        for arm in job.arms:
            self.arms[arm.name] = self._arm(arm, loops, say)
        self.robots = [*self.bases.values(), *self.arms.values()]
        self.supervisor = Supervisor(self.robots)
        self._collisions = Collisions(job.obstacles)
        self._events = sorted(job.events, key=lambda event: event.at)
        self._rng = np.random.default_rng([job.seed, 1])
        self._ticks = 0
        put_stated(job, recorder)
        deciding = bool(job.arms or job.events or job.sensors or job.obstacles or len(job.bases) > 1)
        for b in job.bases:
            deciding = deciding or bool(b.task.velocities is not None or b.task.after is not None or b.payloads)
        self._step = 1 if deciding else LONG
        self._observe()

    def _arm(self, job: ArmJob, loops: Simulated, say: Callable[[str], None]) -> ArmRig:
        carried = job.mount is not None and job.mount.robot is not None
        stands = np.linalg.inv(np.array(job.arm.model.base)) if carried else np.eye(4)
        own = self._recorder.scoped(job.name, job.arm.limits.names)
        sink = ArmSink(own, say, job, BASE if carried else "world", stands)
        believed = true = None
        mount = job.mount
        if mount is not None and mount.robot is not None:
            carrier = self.bases[mount.robot]
            on_base = carrier.job.frames[mount.frame] @ mount.T
            believed = Group(carrier.loop.controller, on_base).frame
            true = _carried(carrier, mount)
        return ArmRig(
            job, loops.arms[job.name], self.world, sink, self.signals, seed=self.job.seed, longest=self.job.time_limit,
            believed=believed, true=true,
        )  # fmt: skip

    @property
    def time(self) -> float:
        """Simulated time, s."""
        if len(self.robots) == 1:
            return float(self.robots[0].truth.time)
        return TICK * self._ticks

    def run(
        self,
        *,
        stop: Callable[[], bool] = lambda: False,
        overdue: Callable[[], bool] = lambda: False,
        progress: Callable[[float], None] = lambda time: None,
    ) -> Ended:
        """Run to the end, or until `stop` says so; what happened is recorded.

        Parameters
        ----------
        stop, overdue
            Asked between ticks: whether to stop all robots; whether to end although some are not at rest yet.
        progress
            Told the simulated time.
        """
        began = None
        while True:
            running = self.supervisor.state is Supervision.RUNNING
            began = self.time if running or began is None else began
            if running and stop():
                self._recorder.put(Event(self.time, "error", "operator", "stopped"))
                self.supervisor.stop()
            if running:
                self._each(lambda robot: robot.think())
            self._each(lambda robot: robot.advance(self._step))
            self._ticks += self._step
            self._look_around()
            progress(self.time)
            state = self.supervisor.tick()
            late = self.time - began > STANDS
            if state is Supervision.STOPPING and (late or overdue()):
                self._recorder.put(Event(self.time, "warning", "operator", "ended before all robots stood"))
                return self._ended()
            if state is Supervision.STOPPED or (state is Supervision.RUNNING and self._done()):
                return self._ended()

    def _each(self, act: Callable[[RobotRig], None]) -> None:
        for robot in self.robots:
            try:
                act(robot)
            except RunError as fault:
                self._fail(robot, fault)

    def _fail(self, robot: RobotRig | None, fault: RunError, category: StopCategory | None = None) -> None:
        text = str(fault) if robot is None else robot.explain(fault)
        if robot is None:
            self._recorder.put(Event(self.time, "error", "cell", text))
        else:
            robot.log("error", _source_of(fault), text)
        self.supervisor.fail(robot, type(fault)(text), category)

    def _done(self) -> bool:
        if all(robot.done for robot in self.robots):
            return True
        if self.time >= self.job.time_limit - 1e-9:
            self._fail(None, ProgramFault(self._late()))
        return False

    def _late(self) -> str:
        limit = f"not done after {self.job.time_limit:g} s of simulated time, the cell's time_limit"
        places = [arm.where() for arm in self.arms.values() if not arm.done and arm.where()]
        bases = [base.where() for base in self.bases.values() if not base.done]
        return "\n  ".join([f"{places[0].partition(': ')[0]}: {limit}" if places else limit, *places, *bases])

    def _look_around(self) -> None:
        """Events of the cell, its sensors, its parts, and what was hit."""
        while self._events and self._events[0].at <= self.time + 1e-9:
            event = self._events.pop(0)
            self.signals.set(event.number, event.on, self.time)
        self._observe()
        hit = self._collisions.first(self.bases.values(), self.arms.values())
        if hit is not None and self.supervisor.state is Supervision.RUNNING:
            self._fail(hit.robot, MotionError(hit.text), StopCategory.ZERO_SPEED)

    def _observe(self) -> None:
        now = self.time
        if self.world.discs:
            names = tuple(disc.name for disc in self.world.discs)
            self._recorder.put(FramePoses(now, names, np.stack([disc.pose for disc in self.world.discs])))
        by_name = {robot.name: robot for robot in self.robots}
        for sensor in self.job.sensors:
            values = sensor.sensor.read(by_name[sensor.robot].truth, self._rng)
            self._recorder.put(Reading(now, sensor.name, np.atleast_1d(np.asarray(values, float))))

    def _ended(self) -> Ended:
        fault = self.supervisor.fault
        if fault is not None:
            return Ended(Ending.FAILED, str(fault), self.time, fault)
        if self.supervisor.state is not Supervision.RUNNING:
            return Ended(Ending.STOPPED, "stopped by the operator", self.time)
        if any(robot.paused for robot in self.robots):
            return Ended(Ending.PAUSED, "program at PAUSE", self.time)
        return Ended(Ending.DONE, self._what(), self.time)

    def _what(self) -> str:
        """What was done."""
        if len(self.robots) > 1:
            return "all done"
        if self.arms:
            return "program ended" if self.job.arms[0].program is not None else "it stood"
        return next(iter(self.bases.values())).outcome

    def ending(self, ended: Ended) -> EndingFacts:
        """How it ended, with what no track holds: the worst of each joint at the controllers' own rates."""
        joints = {
            name: {
                joint: {_peak(what): float(values[k]) for what, values in arm.loop.worst.items()}
                for k, joint in enumerate(arm.job.arm.limits.names)
            }
            for name, arm in self.arms.items()
        }
        numbers = {name: {"contact_force": float(arm.loop.touch)} for name, arm in self.arms.items()}
        numbers |= {name: {"path_driven": base.kept} for name, base in self.bases.items() if base.kept is not None}
        return EndingFacts(str(ended.ending), ended.reason, ended.time, joints, numbers)


def _source_of(fault: RunError) -> str:
    """Whose event a fault of a robot is."""
    if isinstance(fault, ProgramFault | MotionError):
        return "program"
    return "contact" if isinstance(fault, ContactFault) else "drive"


def _peak(what: str) -> str:
    return what if what.startswith("rms") else f"peak_{what}"


def _carried(carrier: BaseRig, mount: Mount) -> Callable[[], Array]:
    return lambda: carrier.frame(mount.frame) @ mount.T
