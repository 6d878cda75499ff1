"""The closed loop of a base: `BaseLoop`, stepped or in buffers; `simulate_base`, one whole run along a path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import whole_number
from holonom.closed_loop.base_kernels import LogBuffer, joined, run
from holonom.closed_loop.base_log import BaseLog, log_of
from holonom.machine.base.controller import BaseController
from holonom.machine.base.kernels import DONE, RUNNING, STOPPED
from holonom.machine.base.paths import ReferencePath
from holonom.machine.base.records import CONTROL_SAMPLE, SEEN_WHEEL_SAMPLE
from holonom.machine.base.settings import BaseSettings, Creep
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive
from holonom.signals import Event
from holonom.sim.base.floor import Floor
from holonom.sim.base.plant import TICK, BaseFault, BasePlant
from holonom.sim.base.records import BODY_SAMPLE, WHEEL_SAMPLE
from holonom.trace.code.simd import WIDTH

__all__ = ["BaseLoop", "DrivenPart", "simulate_base"]


SLOWEST = 0.2  # part of the path's speed below which a run is cut off
PIECE = 4000  # ms of a run at once
ENDINGS = {RUNNING: "cut off", DONE: "done", STOPPED: "stopped"}


class BaseLoop:
    """A controller and a simulated base that do not know each other.

    Parameters
    ----------
    controller, plant
        They meet in `plant.signals`.
    """

    def __init__(self, controller: BaseController, plant: BasePlant) -> None:
        self.controller, self.plant = controller, plant
        self._nothing = self.buffer(0)

    def place(self, pose: ArrayLike, twist: ArrayLike = (0.0, 0.0, 0.0), lean: float = 0.0) -> None:
        """Put the base at a pose (3,) with a twist (3,) in base_link, and tell its controller.

        A body that balances leans forwards by `lean`, rad.

        Raises
        ------
        ShapeError
            Not three finite numbers each; it stays where it is.
        ModelError
            A lean of a body that does not balance.
        OutOfLimits
            A lean at which it has fallen.
        """
        self.plant.place(pose, twist)
        if lean != 0.0:
            self.plant.lean(lean)
        self.controller.place(pose, twist, signals=self.plant.signals)

    def advance(self, ticks: int = 10) -> None:
        """Drive on for some milliseconds.

        Raises
        ------
        OutOfLimits
            Not a whole number of them, or a negative one.
        """
        left = whole_number("ticks", ticks)
        while True:
            part = min(left, self.controller.plan())
            run(*self._arguments(), self.plant.noise(part), self._nothing)
            left -= part
            if left <= 0:
                return

    def advance_logged(self, log: LogBuffer) -> int:
        """Drive on until the buffer is full, the path ends or the base tips; return the milliseconds it took."""
        done = 0
        while done < len(log.body):
            part = log.part(done, done + self.controller.plan())
            took = int(run(*self._arguments(), self.plant.noise(len(part.body)), part))
            done += took
            if took < len(part.body):
                break
        return done

    @property
    def going_on(self) -> bool:
        """Whether its path is under way, and the base on its wheels."""
        return self.controller.ending == RUNNING and self.plant.tipped is None

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.plant.time

    def buffer(self, ticks: int) -> LogBuffer:
        """Return an empty buffer for some milliseconds.

        Raises
        ------
        OutOfLimits
            Not a whole number of them, or a negative one.
        """
        ticks = whole_number("ticks", ticks)
        fours, seen = len(self.plant.states), len(SEEN_WHEEL_SAMPLE)
        sizes = [BODY_SAMPLE.itemsize, fours * WHEEL_SAMPLE.itemsize, CONTROL_SAMPLE.itemsize, 8 * seen * WIDTH * fours]
        memory = np.zeros(ticks * sum(sizes), np.uint8)  # one piece: the system gives back and takes several anew
        body, wheels, controlled, rest = np.split(memory, ticks * np.cumsum(sizes)[:-1])
        return LogBuffer(
            body.view(BODY_SAMPLE),
            wheels.view(WHEEL_SAMPLE).reshape(ticks, fours),
            controlled.view(CONTROL_SAMPLE),
            rest.view(np.float64).reshape(ticks, seen, WIDTH * fours),
        )

    def _arguments(self) -> tuple[Any, ...]:
        c, p = self.controller, self.plant
        return c.params, c.task, p.signals, c.state, c.wheels, c.states, c.work, p.params, p.state, p.states


def simulate_base(
    base: WheelBase,
    drive: BaseDrive,
    path: ReferencePath,
    *,
    floor: Floor = Floor(),
    faults: Sequence[BaseFault] = (),
    settings: BaseSettings = BaseSettings(),
    rng: np.random.Generator,
    substeps: int | None = None,
) -> BaseLog:
    """Drive a base along a path; it starts where the path does.

    Controller at 1 kHz: encoders, gyro, accelerometers and shunts; slip detection; watch over the motors; velocity
    and pose by dead reckoning without the slipping wheel; path keeping; forces by the wheels that work; traction
    control; speed loops. It is told of no fault and no patch. Where the motors that are left cannot give the path's
    accelerations it is driven slower (same curve), for at most five times as long; a jammed wheel stops the base, and
    one that tips over ends the run. The log's `ended` and `driven` say how it went. Plant at 1 kHz times `substeps`.

    Parameters
    ----------
    base, drive, floor
        What moves, what drives it, what it stands on.
    path
        Reference at 1 kHz.
    faults
        What breaks, and when.
    settings
        Controllers and sensors.
    rng
        Source of all noise: the same one gives the same bits.
    substeps
        Steps of the plant per millisecond, as `BasePlant` takes them.

    Raises
    ------
    ModelError
        A base that cannot be simulated (`BasePlant`).
    UnknownName
        A fault of a wheel that there is not.
    """
    plant = BasePlant(base, drive, floor, sensors=settings.sensors, faults=faults, rng=rng, substeps=substeps)
    creep = Creep(floor.material.creep, floor.material.peak or 1.0)
    controller = BaseController(base, drive, settings, creep=creep)
    reference = np.ascontiguousarray(np.hstack([path.pose, path.twist, path.acceleration]), float)
    loop = BaseLoop(controller, plant)
    loop.place(reference[0, :3], reference[0, 3:6])
    controller.follow_path(reference)
    log = _whole(loop, len(reference))
    time = TICK * np.arange(len(log.body), dtype=np.float64)
    ended = ENDINGS[controller.ending] if plant.tipped is None else "fell" if base.balances else "tipped"
    if ended == "stopped" and controller.state["jams"][0]:
        ended = "jammed"
    driven = 1.0 if ended == "done" else DrivenPart(path)(float(controller.state["phase"][0]))
    events = [Event(f.time, "warning", "plant", _fault_text(f, plant)) for f in faults]
    events += _ending_events(ended, driven, float(time[-1]))
    residual = controller.params.residual * controller.radii
    return log_of(time, log, base.driven, events, residual, ended=ended, driven=driven, base=base)


def _whole(loop: BaseLoop, length: int) -> LogBuffer:
    """Log to the end of a path of some samples, in buffers as long as it is, or until it takes too long."""
    left = math.ceil(length / SLOWEST)
    logs: list[LogBuffer] = []
    while left > 0 and (not logs or loop.going_on):
        log, done = loop.buffer(min(length, left)), 0
        while done < len(log.body) and loop.going_on:  # little noise at a time stays in the cache
            done += loop.advance_logged(log.part(done, done + PIECE))
        logs.append(log.part(0, done))
        left -= done
    return logs[0] if len(logs) == 1 else joined(logs)


class DrivenPart:
    """Part of a path's length (of its turn, on the spot; else of its time) before a phase in samples."""

    def __init__(self, path: ReferencePath) -> None:
        steps = np.abs(np.diff(path.pose, axis=0))
        lengths = (np.hypot(steps[:, 0], steps[:, 1]), steps[:, 2], np.ones(len(steps)))
        gone = np.cumsum(next(length for length in lengths if length.sum() > 0.0 or length is lengths[-1]))
        self._last = len(steps)
        self._at = np.unique(np.append(np.arange(0, self._last, 50), self._last))
        self._gone = np.append(0.0, gone)[self._at]

    def __call__(self, phase: float) -> float:
        """Return the part, 0 to 1."""
        if phase >= self._last or self._gone[-1] <= 0.0:
            return 1.0
        return float(np.interp(phase, self._at, self._gone) / self._gone[-1])


def _ending_events(ended: str, driven: float, time: float) -> list[Event]:
    """What cut a run short; nothing where it went to the end of the path."""
    texts = {
        "tipped": f"tipped over after {100.0 * driven:.0f} % of the path",
        "fell": f"fell after {100.0 * driven:.0f} % of the path",
        "stopped": f"stopped after {100.0 * driven:.0f} % of the path: what is left does not drive it",
        "jammed": f"stopped with a jammed wheel after {100.0 * driven:.0f} % of the path",
        "cut off": f"cut off after {100.0 * driven:.0f} % of the path: driven too slowly, it takes more than "
        f"{1.0 / SLOWEST:g} times its time",
    }
    return [Event(time, "error", "simulation", texts[ended])] if ended in texts else []


def _fault_text(fault: BaseFault, plant: BasePlant) -> str:
    return fault.text(plant.base.driven)
