"""`SimulatedArm`: an `ArmMachine` on simulated drives, its hand in a world of work pieces, all of it recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.closed_loop.arm_loop import ArmLoop
from holonom.machine.arm.machine import ArmMachine
from holonom.machine.arm.motions import LineSettings
from holonom.signals import DriveState, FramePoses, JointCommand, JointState, Sink
from holonom.sim.arm.world import World

__all__ = ["SimulatedArm", "SimulatedHand"]

Array = NDArray[np.float64]


class SimulatedHand:
    """The hand of a simulated arm: it moves work pieces where the tool truly is, and loads the arm with them."""

    def __init__(self, loop: ArmLoop, world: World) -> None:
        self.loop, self.world = loop, world

    @property
    def max_opening(self) -> float:
        """How far it opens, m."""
        return self.world.gripper.max_opening

    @property
    def idle(self) -> bool:
        """Whether the fingers stand where they were sent, or on a part."""
        return self.world.hand_idle

    def send(self, opening: float) -> None:
        """Send the fingers to an opening, m."""
        self.world.send_hand(opening)

    def step(self, dt: float) -> list[str]:
        """Let the hand and the work pieces move for some time (s)."""
        happened = self.world.step(self.loop.arm.fk(self.loop.plant.q), dt)
        self.loop.plant.payload = self.world.payload
        return happened


class SimulatedArm:
    """What a program moves when there is no hardware: `machine` for the program, `loop` and `world` for the rest.

    Parameters
    ----------
    loop, world
        The arm with its drives and servos; what it can touch.
    sink
        Where records go.
    look, ready, line
        See `ArmMachine`.
    """

    def __init__(
        self,
        loop: ArmLoop,
        world: World,
        sink: Sink,
        *,
        look: Callable[[], Sequence[Any]],
        ready: Array,
        line: LineSettings,
    ) -> None:
        self.loop, self.world, self._sink = loop, world, sink
        self.machine = ArmMachine(
            loop.arm,
            loop,
            SimulatedHand(loop, world),
            sink,
            look=look,
            start=loop.plant.q,
            ready=ready,
            line=line,
            levels=loop.settings.levels,
            observe=self._record,
        )
        self._record(self.machine.queue.present())

    def _record(self, reference: Array) -> None:
        now, states = self.loop.time, self.loop.plant.states
        put = self._sink.put
        put(JointCommand(now, *reference))
        put(JointState(now, states["position"].copy(), states["speed"].copy(), states["torque"].copy()))
        put(DriveState(now, states["current"].copy(), states["voltage"].copy()))
        put(self.frames(now))

    def frames(self, now: float) -> FramePoses:
        """World poses of the links, the tool, the fingers and the parts."""
        frames = self.loop.arm.frames(self.loop.plant.q)
        tool = frames[-1]
        names = [f"link{k + 1}" for k in range(self.loop.arm.n)] + ["tool"]
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
