"""`SimulatedMachine`: what an ARPS program moves when there is no hardware. It satisfies `lang.Machine`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.errors import DriveFault
from holonom.mechanics.motion import Trajectory, splice, stop
from holonom.signals import DriveState, Event, FramePoses, JointCommand, JointState, Signal, Sink
from holonom.machine.arm.motions import LineSettings, MotionRequest, plan
from holonom.sim.arm.plant import TICK, Plant
from holonom.sim.arm.world import World

__all__ = ["PROGRAM_TICK", "SimulatedMachine"]

Array = NDArray[np.float64]

PROGRAM_TICK = 0.01
"""Interval of the program and of the recording, s."""
SAMPLES = round(PROGRAM_TICK / TICK)
SETTLED = {"fine": 2e-4, "coarse": 2e-3}
"""Following error (rad) below which a motion counts as ended."""
SETTLED_SPEED = 0.02
"""Joint speed (rad/s) below which the arm counts as standing."""


class SimulatedMachine:
    """A plant with a trajectory queue, a hand, a camera and signals."""

    def __init__(
        self,
        plant: Plant,
        world: World,
        sink: Sink,
        *,
        look: Callable[[], Sequence[Any]],
        ready: Array,
        line: LineSettings,
    ) -> None:
        self.plant, self.world, self.line = plant, world, line
        self.arm = plant.arm
        self._sink, self._look, self._ready = sink, look, ready
        self._planned = _standing(plant.q)
        self._consumed = len(self._planned.q)
        self._line_before = 0
        self._blend = True
        self._tolerance = "coarse"
        self._parts: list[Any] = []
        self._signals: dict[int, bool] = {}
        self._record(self._planned.q[-1], np.zeros(self.arm.n), np.zeros(self.arm.n))

    # --- what lang.Machine asks for -----------------------------------------------------------------------------

    def move(self, motion: MotionRequest) -> bool:
        """Take a motion, blended into the present one if both allow it; False while one is already waiting."""
        if self.idle():
            self._planned, self._consumed = plan(self.arm, self._planned.q[-1], motion, self.line), 0
        elif self._blend and self._consumed >= self._planned.begin:
            following = plan(self.arm, self._planned.q[-1], motion, self.line)
            self._line_before = self.active_line
            self._planned = splice(self._planned, self._consumed, following, self.arm.limits)
            self._consumed = 0
        else:
            return False
        self._blend, self._tolerance = motion.blend, motion.tolerance
        return True

    def idle(self) -> bool:
        """Whether all motions have ended and the arm has settled."""
        if self._consumed < len(self._planned.q):
            return False
        error = np.abs(self._planned.q[-1] - self.plant.states["position"]).max()
        speed = np.abs(self.plant.states["speed"]).max()
        return bool(error < SETTLED[self._tolerance] and speed < SETTLED_SPEED)

    def set_hand(self, closed: bool) -> None:
        """Close or open the hand."""
        self.world.send_hand(0.0 if closed else self.world.gripper.max_opening)

    def hand_idle(self) -> bool:
        """Whether the fingers have arrived, at their opening or on a part."""
        return self.world.hand_idle

    def set_signal(self, number: int, on: bool) -> None:
        """Switch a digital output."""
        if self._signals.get(number, False) != on:
            self._signals[number] = on
            self._sink.put(Signal(self.time(), number, on))

    def signal(self, number: int) -> bool:
        """Read back a digital output; inputs of the simulated cell are its outputs."""
        return self._signals.get(number, False)

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
        return self.arm.fk(self._planned.q[-1].copy())

    def joints(self) -> Array:
        """Present joint positions (n,)."""
        return self.plant.q

    def pose(self) -> Array:
        """Present T_wt (4, 4)."""
        return self.arm.fk(self.plant.q)

    def ready_joints(self) -> Array:
        """The READY position (n,)."""
        return self._ready

    def time(self) -> float:
        """Simulated time, s."""
        return self.plant.time

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
        if self._consumed >= len(self._planned.q):
            return 0
        return self._planned.line if self._consumed >= self._planned.begin else self._line_before

    def advance(self) -> None:
        """Advance everything by one program tick.

        Raises
        ------
        DriveFault, MotionError
            An axis left its limits, or a finger hit a part.
        """
        self.plant.advance(self._next_samples())
        try:
            for what in self.world.step(self.pose(), PROGRAM_TICK):
                self.log("info", "hand", what, self.active_line)
        finally:
            self._record(*self._present_reference())
        self.plant.payload = self.world.payload

    def halt(self) -> None:
        """End the motion in a controlled way: brake along the path, or hold zero speed after a drive fault."""
        rest = stop(self._planned, min(self._consumed, len(self._planned.q) - 1), self.arm.limits)
        self._planned, self._consumed, self._blend = rest, 0, False
        try:
            while self._consumed < len(self._planned.q):
                self.plant.advance(self._next_samples())
                self._record(*self._present_reference())
        except DriveFault:
            self.brake()

    def brake(self, duration: float = 0.3) -> None:
        """Hold zero speed whatever the reference was."""
        for _ in range(round(duration / PROGRAM_TICK)):
            self.plant.brake(SAMPLES)
            here, still = self.plant.q, np.zeros(self.arm.n)
            self._record(here, still, still)
        self._planned = _standing(self.plant.q)
        self._consumed = len(self._planned.q)

    def _next_samples(self) -> Array:
        """The next 10 reference samples (3, 10, n); the last one is held."""
        last = len(self._planned.q) - 1
        k = np.minimum(np.arange(self._consumed, self._consumed + SAMPLES), last)
        self._consumed = min(self._consumed + SAMPLES, last + 1)
        return np.stack([self._planned.q[k], self._planned.qd[k], self._planned.qdd[k]])

    def _present_reference(self) -> Array:
        """The reference (3, n) of this instant: the sample that the next tick begins with."""
        k = min(self._consumed, len(self._planned.q) - 1)
        return np.stack([self._planned.q[k], self._planned.qd[k], self._planned.qdd[k]])

    def _record(self, q: Array, qd: Array, qdd: Array) -> None:
        now, states = self.time(), self.plant.states
        put = self._sink.put
        put(JointCommand(now, q, qd, qdd))
        put(JointState(now, states["position"].copy(), states["speed"].copy(), states["torque"].copy()))
        put(DriveState(now, states["current"].copy(), states["voltage"].copy()))
        put(self.frames(now))

    def frames(self, now: float) -> FramePoses:
        """World poses of the links, the tool, the fingers and the parts."""
        frames = self.arm.frames(self.plant.q)
        tool = frames[-1]
        names = [f"link{k + 1}" for k in range(self.arm.n)] + ["tool"]
        poses = [*frames[1:-1], tool]
        for name, side in (("finger_left", 0.5), ("finger_right", -0.5)):
            finger = tool.copy()
            finger[:3, 3] += side * self.world.opening * tool[:3, 1]
            names.append(name)
            poses.append(finger)
        for disc in self.world.discs:
            names.append(disc.name)
            poses.append(disc.pose)
        return FramePoses(now, tuple(names), np.stack(poses))


def _standing(q: Array) -> Trajectory:
    rest = np.zeros((1, q.shape[0]))
    return Trajectory(TICK, q[None].copy(), rest, rest.copy())
