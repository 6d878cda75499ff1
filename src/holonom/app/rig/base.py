"""`BaseRig`: a mobile base that drives its path, follows its velocities or holds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holonom.app.job import BaseJob
from holonom.app.recording.robot import WheelCreep
from holonom.app.rig.base_records import BaseRecords
from holonom.app.rig.path_judge import PathJudge
from holonom.arrays import Array
from holonom.closed_loop import BaseLoop
from holonom.closed_loop.base import DrivenPart
from holonom.closed_loop.base_words import BaseWords, why_stopped
from holonom.errors import DriveFault
from holonom.machine import BaseController, Creep
from holonom.machine.base.kernels import RUNNING, STOPPED
from holonom.machine.base.paths import sampled
from holonom.machine.digital import DigitalSignals
from holonom.machine.group import planar_pose
from holonom.machine.supervisor import StopCategory
from holonom.signals import Event, Sink
from holonom.sim import BasePlant, Floor
from holonom.sim.base.balancing import FALLEN
from holonom.sim.base.log import of_wheels

__all__ = ["BaseRig", "BaseTruthView", "creep_of", "make_base"]


MS = 10  # of a tick
STILL = 5e-3
"""Speed (m/s, and rad/s times the base's radius) below which a base stands."""
SLOWEST = 0.2  # part of the path's speed below which a run is cut off


class BaseTruthView(NamedTuple):
    """What is so of a base: time (s), pose (3,) in the world, twist (3,) and acceleration (2,) in base_link."""

    time: float
    pose: Array
    twist: Array
    acceleration: Array


def make_base(job: BaseJob, floor: Floor, rng: np.random.Generator) -> BaseLoop:
    """Return the base with its controller, standing where it starts."""
    ideal = job.drives == "ideal"
    plant = BasePlant(job.base, job.drive, floor, sensors=job.sensors, faults=job.faults, rng=rng, ideal=ideal)
    settings = job.settings.without_motors() if ideal else job.settings
    loop = BaseLoop(
        BaseController(job.base, job.drive, settings, creep=Creep(0.0, 1.0) if ideal else creep_on(floor)), plant
    )
    path, twist = job.task.path, (0.0, 0.0, 0.0)
    if path is not None and job.task.after is None and job.task.start == 0.0:
        twist = tuple(path.twist[0])
    loop.place(job.pose, twist, job.lean)
    return loop


def creep_on(floor: Floor) -> Creep:
    """Return what a controller may know of wheels that grip a floor."""
    return Creep(floor.material.creep, floor.material.peak or 1.0)


class BaseRig:
    """A base with its task.

    Parameters
    ----------
    job
        What it is and does.
    loop
        It with its controller, standing where it starts.
    floor, sink, signals
        What it stands on, where its records go, the cell's signals.
    alone
        Whether it is the only robot: its run ends to the millisecond where its path does.
    """

    def __init__(
        self, job: BaseJob, loop: BaseLoop, floor: Floor, sink: Sink, signals: DigitalSignals, *, alone: bool
    ) -> None:
        self.job, self.name, self.loop, self._sink, self._signals = job, job.name, loop, sink, signals
        controller = loop.controller
        self._records = BaseRecords(job, creep_on(floor), controller.params.residual * controller.radii, sink)
        self._words = BaseWords(job.base.driven, floor.material.slip_at_peak, job.base, job.settings.keep)
        self._faults = sorted(job.faults, key=lambda fault: fault.time)
        self._payloads = list(job.payloads)
        self._alone, self._log = alone, loop.buffer(0)
        self._began: float | None = None
        self._ended, self._stopping = False, False
        self._part = DrivenPart(job.task.path) if job.task.path is not None else None
        self._judge = PathJudge(job) if job.task.tolerance is not None else None

    @property
    def done(self) -> bool:
        """Whether its task is at its end."""
        return self._ended

    @property
    def driven(self) -> float | None:
        """Part of its path that it has driven, 0 to 1; None without one."""
        if self._part is None:
            return None
        if self._began is None:
            return 0.0
        return 1.0 if self._ended else self._part(float(self.loop.controller.state["phase"][0]))

    @property
    def paused(self) -> bool:
        """A base has no program."""
        return False

    @property
    def speed(self) -> float:
        """Greatest speed of its middle and of its rim about it, m/s."""
        x, y, turn = np.abs(self.loop.plant.twist)
        return float(max(x, y, turn * self.job.base.radius))

    @property
    def standing(self) -> bool:
        """Whether it stands, or has fallen over."""
        return self.speed < STILL or self._lying

    @property
    def _lying(self) -> bool:
        return self.loop.plant.tipped is not None

    @property
    def outcome(self) -> str:
        """What it has done, in words, once it has."""
        task = self.job.task
        if task.path is None:
            return "velocities driven" if task.velocities is not None else "held its place"
        given_up = "" if self._judge is None else self._judge.given_up
        return f"path driven, {given_up} given up for want of motors" if given_up else "path driven"

    @property
    def kept(self) -> float | None:
        """Part of its path that it was truly on, 0 to 1, where that is judged; None without a path."""
        return self.driven if self._judge is None or self._part is None else self._judge.kept

    def where(self) -> str:
        """How far its task is, in words."""
        name, task = self.name or "the base", self.job.task
        if self._began is not None:
            return f"{name}: under way since {self._began:g} s"
        return f"{name}: it waits for signal {task.after}" if task.after is not None else f"{name}: not begun yet"

    @property
    def truth(self) -> BaseTruthView:
        """What sensors of the cell may see of it."""
        plant = self.loop.plant
        return BaseTruthView(plant.time, plant.pose, plant.twist, plant.acceleration)

    def frame(self, name: str) -> Array:
        """Where one of its frames truly is, T (4, 4) in the world."""
        found: Array = planar_pose(self.loop.plant.pose) @ self.job.frames[name]
        return found

    def think(self) -> None:
        """Begin the task when it is time, go on with it, and end it.

        Raises
        ------
        DriveFault
            It did not do what it was to do.
        """
        task, now = self.job.task, self.loop.time
        while self._payloads and self._payloads[0][0] <= now + 1e-9:
            _, payload = self._payloads.pop(0)
            self.loop.plant.carry(payload)
            self.log("info", "plant", f"it carries {payload.mass:g} kg from here on")
        if self._began is None:
            waits = not self._signals.get(task.after) if task.after is not None else now < task.start
            if waits:
                return
            self._began = now
            if task.path is not None:
                path = sampled(task.path, self.job.levels)
                self.loop.controller.follow_path(np.hstack([path.pose, path.twist, path.acceleration]))
        since = now - self._began
        if task.velocities is not None and not self._ended:
            rows = task.velocities[task.velocities[:, 0] <= since + 1e-9]
            if len(rows):
                self.loop.controller.follow_velocity(rows[-1, 1:])
            if len(rows) == len(task.velocities) and not rows[-1, 1:].any() and self.standing:
                self._finish()
        elif task.path is None and not self._ended and since >= (task.hold or 0.0) - 1e-9:
            self._finish()

    def advance(self, ticks: int) -> None:
        """Advance by some ticks.

        Raises
        ------
        DriveFault
            A jammed wheel stopped it, it tips over, gets too slow for its path, or did not keep it.
        """
        left = MS * ticks
        while left > 0 and not self._lying:
            first, done = int(self.loop.plant.state["tick"][0]), self._drive(left)
            left -= done
            if done:
                self._say(first, done)
            if self._lying:
                raise DriveFault(self._tipped())
            if self._running_path and self.loop.controller.ending != RUNNING:
                self._path_ended()
                if self._alone:
                    return
        if self._too_slow():
            raise DriveFault(self._cut("cut off", ": driven too slowly, it takes more than 5 times its time"))

    def _too_slow(self) -> bool:
        path = self.job.task.path
        if path is None or self._began is None or self._ended or self._stopping:
            return False
        return self.loop.time - self._began > float(path.time[-1]) / SLOWEST

    @property
    def _running_path(self) -> bool:
        return self._began is not None and self.job.task.path is not None and not self._ended

    def _drive(self, ms: int) -> int:
        if len(self._log.body) != ms:
            self._log = self.loop.buffer(ms)
        return self.loop.advance_logged(self._log)

    def _say(self, first: int, done: int) -> None:
        """Records and events of the milliseconds that were driven."""
        log = self._log.part(0, done)
        self._records.put(first, log)
        if self._judge is not None and self._began is not None and not self._ended:
            self._judge.see(first, log)
        slip = of_wheels(log.wheels, "slip", len(self.job.base.driven))
        for event in [
            *self._broken(1e-3 * (first + done)),
            *self._words.events(first, log.controlled, slip, float(self.loop.controller.state["goal"][0])),
        ]:
            self._sink.put(event)

    def _broken(self, until: float) -> list[Event]:
        found = []
        while self._faults and self._faults[0].time < until:
            fault = self._faults.pop(0)
            found.append(Event(fault.time, "warning", "plant", fault.text(self.job.base.driven)))
        return found

    def _path_ended(self) -> None:
        """At the end of its path it holds; stopped on the way it has failed."""
        stopped = self.loop.controller.ending == STOPPED
        self.loop.controller.hold()
        if not stopped:
            self._finish()
        elif not self._stopping:
            raise DriveFault(self._cut(f"stopped {why_stopped(self.loop.controller.state[0])}"))

    def _finish(self) -> None:
        """End the task by what it truly came to."""
        verdict = "" if self._judge is None else self._judge.verdict()
        self._ended = True
        if verdict:
            raise DriveFault(verdict)
        self._end(self.outcome)

    def _tipped(self) -> str:
        """What tips it or makes it fall, in words."""
        plant, (ax, ay) = self.loop.plant, (float(self.loop.plant.state[name][0]) for name in ("ax", "ay"))
        height, time = 1e3 * self.job.base.com_height, plant.tipped or 0.0
        where = f" after {100.0 * (self.driven or 0.0):.0f} % of the path" if self._part is not None else ""
        lean = float(plant.pitch[0])
        if abs(lean) >= FALLEN:
            return (
                f"falls {'forwards' if lean > 0.0 else 'backwards'} at {time:.2f} s{where}: its body leans "
                f"{np.degrees(abs(lean)):.0f} deg, more than its wheels can catch; drive more gently, begin more "
                "upright, or give it stronger motors or more grip"
            )
        return (
            f"tips over at {time:.2f} s{where}: {np.hypot(ax, ay):.1f} m/s2 are more than its wheels and a centre of "
            f"mass at {height:g} mm stand; accelerate and turn less, build lower, or move the centre of mass inwards"
        )

    def _cut(self, what: str, why: str = "") -> str:
        return f"{what} after {100.0 * (self.driven or 0.0):.0f} % of the path{why}"

    def _end(self, what: str) -> None:
        self._ended = True
        self.log("info", "path", what)
        if self.job.task.done is not None:
            self._signals.set(self.job.task.done, True, self.loop.time)

    def begin_stop(self, category: StopCategory) -> None:
        """Stop from the next tick on: slower and slower along the path, or at once where it is."""
        self._stopping = True
        controller = self.loop.controller
        if category is StopCategory.ON_PATH and self._running_path:
            controller.state["goal"] = 0.0
        else:
            controller.hold()

    def explain(self, fault: Exception) -> str:
        """Word a fault."""
        return f"{self.name}: {fault}" if self.name else str(fault)

    def log(self, level: str, source: str, text: str) -> None:
        """Record an event of it."""
        self._sink.put(Event(self.loop.time, level, source, text))


def creep_of(controller: BaseController) -> WheelCreep:
    """Return what a controller knows of its wheels' creep, as its recording says it."""
    params, m = controller.params, len(controller.radii)
    return WheelCreep(
        tuple(params.grip_per_ampere[:m].tolist()), tuple(params.creep[:m].tolist()), float(params.creep_across)
    )
