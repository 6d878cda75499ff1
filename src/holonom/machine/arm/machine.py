"""`ArmMachine`: what a program moves, behind `lang.Machine`: motions and servos, a hand, signals, a camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, isfinite
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.errors import DriveFault, LevelFault, MotionError
from holonom.machine.arm.clock import PROGRAM_TICK, samples_per_tick
from holonom.machine.arm.motions import LineSettings, MotionRequest
from holonom.machine.arm.queue import MotionQueue
from holonom.machine.arm.steady import SteadyTool
from holonom.machine.digital import DigitalSignals
from holonom.machine.drives import ArmDrives, Hand
from holonom.machine.levels import Levels
from holonom.mechanics import Arm
from holonom.model.joint_values import in_degrees
from holonom.signals import Event, Sink
from holonom.spatial import inverse

__all__ = ["ArmMachine"]


SETTLED = {"fine": 2e-4, "coarse": 2e-3}
"""Following error (rad or m) below which a motion counts as ended."""
SETTLED_SPEED = 0.02
"""Joint speed (rad/s or m/s), over a program tick, below which the arm counts as standing."""


class ArmMachine:
    """The controller of an arm, one program tick at a time.

    Parameters
    ----------
    arm
        Its model, on its base, with its tool.
    drives
        What follows the references.
    hand
        What it grasps with; None: it has none.
    sink
        Where events and signals go.
    look
        Takes a picture: the parts the camera sees now.
    start, ready
        Joints (n,) where it stands at first, and those of the READY position.
    line
        What 100 % means on straight lines.
    levels
        Periods of supervisor, model and servos.
    longest
        Longest time that a motion may take, s.
    patience
        How long somebody may wait for the arm to settle after its motions, s.
    frame
        T (4, 4) of its base in the world where another robot carries it, as that one believes to stand.
    steady
        Whether, between its motions, the tool stays where it is in the world while the base moves.
    signals
        Those of the cell; None: it has its own.
    observe
        Called after each tick with the reference (3, n) of that instant: the recorder's moment.
    """

    def __init__(
        self,
        arm: Arm,
        drives: ArmDrives,
        hand: Hand | None,
        sink: Sink,
        *,
        look: Callable[[], Sequence[Any]],
        start: Array,
        ready: Array,
        line: LineSettings,
        levels: Levels = Levels(),
        longest: float = inf,
        patience: float = inf,
        frame: Callable[[], Array] | None = None,
        steady: bool = False,
        signals: DigitalSignals | None = None,
        observe: Callable[[Array], None] = lambda reference: None,
    ) -> None:
        self.arm, self.drives, self.hand = arm, drives, hand
        self.queue = MotionQueue(arm, start, line, levels, longest=longest)
        self._sink, self._look, self._ready, self._observe, self._frame = sink, look, ready, observe, frame
        self._before, self._braking, self._halting = drives.position, 0, False
        self._patience, self._asked_since = patience, inf
        self._samples = samples_per_tick(levels.servo)
        self._parts: list[Any] = []
        self._steady = SteadyTool(arm, frame, PROGRAM_TICK) if steady and frame is not None else None
        self._signals = signals if signals is not None else DigitalSignals(sink)

    # --- what lang.Machine asks for -----------------------------------------------------------------------------

    def move(self, motion: MotionRequest) -> bool:
        """Take a motion, blended into the present one if both allow it; False while one is already waiting."""
        idle, self._halting, self._asked_since = self.idle(), False, inf
        if self._steady is not None:
            self._steady.release()
        return self.queue.move(self._on_base(motion) if self._frame is not None else motion, idle=idle)

    def idle(self) -> bool:
        """Whether all motions have ended and the arm has settled."""
        if not self.queue.empty:
            return False
        error = np.abs(self.queue.goal - self.drives.position).max()
        settled = bool(error < SETTLED[self.queue.tolerance] and self._stands)
        self._asked_since = inf if settled else min(self._asked_since, self.time())
        return settled

    def set_hand(self, closed: bool) -> None:
        """Close or open the hand."""
        if self.hand is None:
            raise MotionError("this arm has no hand to close or open; give its cell a [gripper]")
        self.hand.send(0.0 if closed else self.hand.max_opening)

    def hand_idle(self) -> bool:
        """Whether the fingers have arrived, at their opening or on a part."""
        return self.hand is None or self.hand.idle

    def set_signal(self, number: int, on: bool) -> None:
        """Switch a digital output."""
        self._signals.set(number, on, self.time())

    def signal(self, number: int) -> bool:
        """Read a digital signal of the cell, whoever switches it."""
        return self._signals.get(number)

    def picture(self) -> int:
        """Take a picture: the parts the camera sees now."""
        self._parts = list(self._look())
        self.log("info", "camera", f"{len(self._parts)} parts seen")
        return len(self._parts)

    def locate(self, kind: str) -> Any:
        """Return the next part of this kind ("" for any), None when there is none left."""
        for k, part in enumerate(self._parts):
            if kind in ("", part.kind):
                return self._parts.pop(k)
        return None

    def destination(self) -> Array:
        """T_wt where the last commanded motion ends."""
        return self._in_world(self.arm.fk(self.queue.goal))

    def turns(self) -> tuple[bool, ...]:
        """Of each joint whether it turns."""
        return self.arm.limits.turns

    def goal(self) -> Array:
        """Joints (n,) where the last commanded motion ends."""
        return self.queue.goal

    def joints(self) -> Array:
        """Measured joint positions (n,)."""
        return self.drives.position

    def pose(self) -> Array:
        """Measured T_wt (4, 4)."""
        return self._in_world(self.arm.fk(self.drives.position))

    def ready_joints(self) -> Array:
        """The READY position (n,)."""
        return self._ready

    def time(self) -> float:
        """Time of the drives' clock, s."""
        return self.drives.time

    def say(self, text: str, line: int) -> None:
        """Log what TYPE says."""
        self.log("info", "program", text, line)

    # --- the clock's side ---------------------------------------------------------------------------------------

    def log(self, level: str, source: str, text: str, line: int = 0) -> None:
        """Put an event into the recording."""
        self._sink.put(Event(self.time(), level, source, text, line))

    @property
    def active_line(self) -> int:
        """Source line of the motion under way, 0 when standing."""
        return self.queue.active_line

    @property
    def last_line(self) -> int:
        """Source line of the motion that was taken last."""
        return self.queue.planned.line

    def advance(self) -> None:
        """Advance everything by one program tick: along the path, or braking.

        Raises
        ------
        DriveFault, LevelFault, MotionError
            An axis left its limits, the supervisor failed, a finger hit a part, or the arm did not settle in time.
        """
        self._before = self.drives.position
        if self._steady is None and self._braking == 0 and self.time() > self._asked_since + self._patience:
            waits, self._asked_since = self.unsettled(), inf
            raise MotionError(f"{waits} (it waited {self._patience:g} s: limits.settle_time)")
        if self._braking > 0:
            self._braking -= 1
            self.drives.brake(self._samples)
            still = np.zeros(self.arm.n)
            self._observe(np.stack([self.drives.position, still, still]))
            if self._braking == 0:
                self.queue.place(self.drives.position)
            return
        self.drives.advance(self._references())
        try:
            for what in self.hand.step(PROGRAM_TICK) if self.hand is not None else ():
                self.log("info", "hand", what, self.active_line)
        except MotionError:
            if not self._halting:  # a finger that hit something is still there while the arm brakes
                raise
        finally:
            self._observe(self.queue.present())

    def unsettled(self) -> str:
        """Which joint has not arrived where it was sent: how far it is away, and what holds it; "" if nobody waits."""
        if not isfinite(self._asked_since):
            return ""
        error, limits = self.queue.goal - self.drives.position, self.arm.limits
        joint = int(np.argmax(np.abs(error)))
        away = in_degrees(abs(float(error[joint])), limits.turns[joint])
        held = self.drives.at_limit()[joint] or "no limit holds it back"
        return f"the arm does not come to rest: {limits.names[joint]} is {away} from where it was sent, {held}"

    def _references(self) -> Array:
        """Those of the next tick (3, samples, n): of the motion under way, or what keeps the tool where it is."""
        if self._steady is None or not self.queue.empty or self._halting:
            return self.queue.take(self._samples)
        reference = self._steady.reference(self.queue.goal, self._samples)
        self.queue.place(reference[0, -1])
        return reference

    def begin_halt(self) -> None:
        """Brake along the path from the next tick on (stop category 1 or 2)."""
        self.queue.brake()
        self._halting = True

    def begin_brake(self, duration: float = 0.3) -> None:
        """Hold zero speed from the next tick on, whatever the reference was: after a fault of drives or levels."""
        self._braking = round(duration / PROGRAM_TICK)

    @property
    def stopped(self) -> bool:
        """Whether a halt has come to its end and the arm stands."""
        return self._braking == 0 and self.queue.empty and self._stands

    @property
    def _stands(self) -> bool:
        """Whether no joint moved in the last program tick."""
        moved = np.abs(self.drives.position - self._before).max()
        return bool(moved < SETTLED_SPEED * PROGRAM_TICK)

    def halt(self) -> None:
        """End the motion in a controlled way: brake along the path, or hold zero speed after a drive fault."""
        self.begin_halt()
        try:
            self._until_stopped()
        except (DriveFault, LevelFault):
            self.brake()

    def brake(self, duration: float = 0.3) -> None:
        """Hold zero speed whatever the reference was."""
        self.begin_brake(duration)
        self._until_stopped()

    def _until_stopped(self) -> None:
        while not self.stopped:
            self.advance()

    def _in_world(self, T_bt: Array) -> Array:
        return T_bt if self._frame is None else self._frame() @ T_bt

    def _on_base(self, motion: MotionRequest) -> MotionRequest:
        """A motion to a pose in the world as one on the base where it stands now."""
        assert self._frame is not None
        return motion if motion.pose is None else motion.to(inverse(self._frame()) @ motion.pose)
