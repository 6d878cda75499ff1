"""`SimulatedArm`: an `ArmMachine` on simulated drives, its hand in a world of work pieces, all of it recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.closed_loop.arm_loop import ArmLoop
from holonom.closed_loop.ideal_arm import IdealArm
from holonom.machine.arm.machine import ArmMachine
from holonom.machine.arm.motions import LineSettings
from holonom.machine.digital import DigitalSignals
from holonom.signals import (
    DriveState,
    DriveTruth,
    EncoderCounts,
    FramePoses,
    JointCommand,
    JointState,
    JointTruth,
    Sink,
)
from holonom.sim.arm.world import Fingers

__all__ = ["SimulatedArm", "SimulatedHand"]

Frame = Callable[[], Array]


class SimulatedHand:
    """The hand of a simulated arm: it moves work pieces where the tool truly is, and loads the arm with them."""

    def __init__(self, loop: ArmLoop | IdealArm, fingers: Fingers, pose: Frame) -> None:
        self.loop, self.fingers, self._pose = loop, fingers, pose

    @property
    def max_opening(self) -> float:
        """How far it opens, m."""
        return self.fingers.gripper.max_opening

    @property
    def idle(self) -> bool:
        """Whether the fingers stand where they were sent, or on a part."""
        return self.fingers.idle

    def send(self, opening: float) -> None:
        """Send the fingers to an opening, m."""
        self.fingers.send(opening)

    def step(self, dt: float) -> list[str]:
        """Let the hand and what it holds or drops move for some time (s)."""
        happened = self.fingers.step(self._pose(), dt)
        self.loop.payload = self.fingers.payload
        return happened


class SimulatedArm:
    """What a program moves when there is no hardware: `machine` for the program, `loop` and `fingers` for the rest.

    Parameters
    ----------
    loop
        The arm with its drives.
    fingers
        Its gripper in the world; None: it has none.
    sink
        Where records go.
    look, ready, line, steady
        See `ArmMachine`.
    signals
        Those of the cell.
    believed, true
        T (4, 4) of its base where another robot carries it: as that one believes to stand, and as it does.
    """

    def __init__(
        self,
        loop: ArmLoop | IdealArm,
        fingers: Fingers | None,
        sink: Sink,
        *,
        look: Callable[[], Sequence[Any]],
        ready: Array,
        line: LineSettings,
        believed: Frame | None = None,
        true: Frame | None = None,
        steady: bool = False,
        signals: DigitalSignals | None = None,
    ) -> None:
        self.loop, self.fingers, self._sink, self._true = loop, fingers, sink, true
        self.machine = ArmMachine(
            loop.arm,
            loop,
            None if fingers is None else SimulatedHand(loop, fingers, self.tool_pose),
            sink,
            look=look,
            start=loop.truth.position,
            ready=ready,
            line=line,
            levels=loop.settings.levels,
            frame=believed,
            steady=steady,
            signals=signals,
            observe=self._record,
        )
        self._record(self.machine.queue.present())

    def tool_pose(self) -> Array:
        """Where the tool truly is: T_wt (4, 4)."""
        return self.frames()[-1]

    def frames(self) -> Array:
        """World poses of base, links and tool (n + 2, 4, 4)."""
        frames: Array = self.loop.arm.frames(self.loop.truth.position)
        return frames if self._true is None else self._true() @ frames

    def _record(self, reference: Array) -> None:
        now, measured, truth, put = self.loop.time, self.loop.measured, self.loop.truth, self._sink.put
        put(JointCommand(now, *reference))
        put(JointState(now, measured.position, measured.speed, measured.effort))
        put(JointTruth(now, truth.position, truth.speed, truth.effort))
        if measured.counts is not None:
            put(EncoderCounts(now, measured.counts))
            put(DriveState(now, measured.current, measured.voltage))
            put(DriveTruth(now, truth.current))
        put(self._poses(now))

    def _poses(self, now: float) -> FramePoses:
        """World poses of the links, the tool and the fingers."""
        frames = self.frames()
        tool = frames[-1]
        names = [f"link{k + 1}" for k in range(len(frames) - 2)] + ["tool"]
        poses = [*frames[1:-1], tool]
        for name, side in (("finger_left", 0.5), ("finger_right", -0.5)) if self.fingers is not None else ():
            finger = tool.copy()
            finger[:3, 3] += side * self.fingers.opening * tool[:3, 1]  # type: ignore[union-attr]
            names.append(name)
            poses.append(finger)
        return FramePoses(now, tuple(names), np.stack(poses))
