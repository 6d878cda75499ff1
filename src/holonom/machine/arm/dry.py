"""`DryMachine`: an arm without dynamics, for checking a program off-line. It satisfies `lang.Machine`."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.errors import MotionError
from holonom.machine.arm.clock import PROGRAM_TICK
from holonom.machine.arm.motions import LineSettings, MotionRequest, plan
from holonom.mechanics import Arm
from holonom.mechanics.motion import Trajectory

__all__ = ["DryMachine", "Problem"]


@dataclass(frozen=True, slots=True)
class Problem:
    """A motion that cannot be made: program line and cause."""

    line: int
    text: str


class Made(NamedTuple):
    """A planned motion: joints (n,) where it ends, how long it takes (s), what is wrong with it, what to warn of."""

    end: Array
    duration: float
    problem: str | None = None
    warning: str | None = None


KNOWN = 4096
"""Planned motions that are remembered."""


class DryMachine:
    """Every motion is planned exactly as the simulation would, then taken as done; one in a tick.

    `problems` collects what could not be planned; the arm then stays where it was. `warnings` are of motions that were.
    A motion that was planned before, from the same place, is not planned again. `moved` counts motions, `time`
    adds up their durations (from rest to rest: an upper estimate of the cycle time).
    """

    def __init__(
        self,
        arm: Arm,
        q: Array,
        *,
        look: Callable[[], Sequence[Any]],
        ready: Array,
        line: LineSettings,
        hand_time: float,
        longest: float = inf,
    ) -> None:
        self.arm, self.line, self.longest = arm, line, longest
        self.problems: list[Problem] = []
        self.warnings: list[Problem] = []
        self._known: dict[Hashable, Made] = {}
        self.moved = 0
        self.typed: list[str] = []
        self._q, self._ready, self._look, self._hand_time = q.copy(), ready, look, hand_time
        self._clock = 0.0
        self._moved_in_tick = False
        self._parts: list[Any] = []
        self._signals: dict[int, bool] = {}

    def move(self, motion: MotionRequest) -> bool:
        """Plan a motion and take it as made; False until the next tick after one was taken."""
        if self._moved_in_tick:
            return False
        self._moved_in_tick = True
        self.moved += 1
        key = self._key(motion)
        made = self._known.get(key)
        if made is None:
            made = self._plan(motion)
            if len(self._known) >= KNOWN:
                self._known.clear()
            self._known[key] = made
        if made.problem is not None:
            self.problems.append(Problem(motion.line, made.problem))
        if made.warning is not None:
            self.warnings.append(Problem(motion.line, made.warning))
        self._q = made.end.copy()
        self._clock += max(made.duration - PROGRAM_TICK, 0.0)
        return True

    def _plan(self, motion: MotionRequest) -> Made:
        try:
            trajectory = plan(self.arm, self._q, motion, self.line, longest=self.longest)
        except MotionError as problem:
            return Made(self._q, 0.0, str(problem))
        return Made(trajectory.end, trajectory.duration, *self.look_at(trajectory))

    def look_at(self, trajectory: Trajectory) -> tuple[str | None, str | None]:
        """Return what is wrong with a planned motion, and what is to be warned of; None where nothing is."""
        del trajectory
        return None, None

    def around(self) -> tuple[Hashable, ...]:
        """Return what `look_at` depends on beside the motion."""
        return ()

    def _key(self, motion: MotionRequest) -> Hashable:
        """What decides about a motion, joints and places to a billionth: programs repeat motions, laps their laps."""
        target = motion.pose if motion.pose is not None else motion.joints
        given = [part.ravel() for part in (self._q, target) if part is not None]
        numbers = tuple(round(value, 9) + 0.0 for value in np.concatenate(given).tolist())
        settings = (motion.speed, motion.speed_mps, motion.acceleration, motion.configuration)
        return (motion.kind, motion.pose is None, numbers, settings, self.around())

    def tick(self) -> None:
        """Let a program tick pass, the first one of a motion where one was taken."""
        self._clock += PROGRAM_TICK
        self._moved_in_tick = False

    def pass_until(self, time: float) -> None:
        """Let time (s) pass up to the tick before a moment, where nothing happens until then."""
        self._clock = max(self._clock, time - PROGRAM_TICK)

    def idle(self) -> bool:
        """Motions end at once."""
        return True

    def set_hand(self, closed: bool) -> None:
        """The hand takes its time."""
        del closed
        self._clock += self._hand_time

    def hand_idle(self) -> bool:
        """The hand arrives at once."""
        return True

    def set_signal(self, number: int, on: bool) -> None:
        """Switch a digital output."""
        self._signals[number] = on

    def signal(self, number: int) -> bool:
        """Read back a digital output."""
        return self._signals.get(number, False)

    def picture(self) -> int:
        """Take the cell's picture."""
        self._parts = list(self._look())
        return len(self._parts)

    def locate(self, kind: str) -> Any:
        """Return the next part of this kind ("" for any), None when there is none left."""
        for k, part in enumerate(self._parts):
            if kind in ("", part.kind):
                return self._parts.pop(k)
        return None

    def destination(self) -> Array:
        """T_wt (4, 4) where the last motion ended."""
        return self.arm.fk(self._q)

    def turns(self) -> tuple[bool, ...]:
        """Of each joint whether it turns."""
        return self.arm.limits.turns

    def goal(self) -> Array:
        """Joint positions (n,) where the last motion ended."""
        return self._q.copy()

    def joints(self) -> Array:
        """Joint positions (n,)."""
        return self._q.copy()

    def pose(self) -> Array:
        """T_wt (4, 4)."""
        return self.arm.fk(self._q)

    def ready_joints(self) -> Array:
        """The READY position (n,)."""
        return self._ready

    def time(self) -> float:
        """Estimated time, s."""
        return self._clock

    def say(self, text: str, line: int) -> None:
        """Keep what TYPE says."""
        del line
        self.typed.append(text)
