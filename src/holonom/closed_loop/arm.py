"""`SimulatedArm`: an `ArmMachine` on simulated drives, its hand in a world of work pieces, all of it recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from math import inf
from typing import Any, NamedTuple

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
from holonom.sim.arm.world import Fingers, Surface, World

__all__ = ["Contact", "SimulatedArm", "SimulatedHand"]

INSIDE = 2e-3
"""m from which the tool of ideal joints is inside a surface, and below which its edge is its side."""
NOWHERE = -1e3
"""Height, m, of the ground where there is none."""

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


class Contact(NamedTuple):
    """What the tool, or what it holds, presses on: the surface's name, the force (N; None: nobody knows), depth (m).

    `beside`: it ran into the surface's side, of which the plant knows no force.
    """

    surface: str
    force: float | None
    depth: float
    beside: bool = False


class SimulatedArm:
    """What a program moves when there is no hardware: `machine` for the program, `loop` and `fingers` for the rest.

    Parameters
    ----------
    loop
        The arm with its drives.
    fingers
        Its gripper in the world; None: it has none.
    world
        The surfaces that it can press on; without any, the ground that its loop was made with.
    sink
        Where records go.
    look, ready, line, longest, patience, steady
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
        longest: float = inf,
        patience: float = inf,
        believed: Frame | None = None,
        true: Frame | None = None,
        steady: bool = False,
        signals: DigitalSignals | None = None,
        world: World | None = None,
    ) -> None:
        self.loop, self.fingers, self._sink, self._true = loop, fingers, sink, true
        self._world = world if world is not None and world.surfaces else None
        self._under: Surface | None = None
        self._depth = -math.inf
        self._beside = False
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
            longest=longest,
            patience=patience,
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

    def contact(self) -> Contact | None:
        """What it pressed on in the last tick; of ideal joints, in what it is inside."""
        force, surface = self.loop.pressing, self._under
        if self._beside and surface is not None:
            return Contact(surface.name, None, self._depth, beside=True)
        if force is None:
            return Contact(surface.name, None, self._depth) if surface is not None and self._depth > INSIDE else None
        if force <= 0.0:
            return None
        return Contact(surface.name if surface is not None else "the ground", force, self._depth)

    def _feel(self, tool: Array) -> None:
        """Let the ground of the plant be what lies under the tool (4, 4), or under what it holds, now."""
        if self._world is None:
            return
        hang = self.fingers.hang * max(-float(tool[2, 2]), 0.0) if self.fingers is not None else 0.0
        low = tool[:3, 3] - [0.0, 0.0, hang]
        before, was, self._under = self._under, self._depth, self._world.under(low, self._under)
        height = self._under.height if self._under is not None else NOWHERE
        self._depth = height - float(low[2])
        # Over an edge the top would push at once with all of the depth; what is met there is the side.
        self._beside = self._depth > INSIDE and (
            self._beside or (self._under is not before and self._depth > was + INSIDE)
        )
        if self._beside:
            height = NOWHERE
        base = 0.0 if self._true is None else float(self._true()[2, 3])
        self.loop.ground = height + hang - base

    def _record(self, reference: Array) -> None:
        frames = self.frames()
        self._feel(frames[-1])
        now, measured, truth, put = self.loop.time, self.loop.measured, self.loop.truth, self._sink.put
        put(JointCommand(now, *reference))
        put(JointState(now, measured.position, measured.speed, measured.effort))
        put(JointTruth(now, truth.position, truth.speed, truth.effort))
        if measured.counts is not None:
            put(EncoderCounts(now, measured.counts))
            put(DriveState(now, measured.current, measured.voltage))
            put(DriveTruth(now, truth.current))
        put(self._poses(now, frames))

    def _poses(self, now: float, frames: Array) -> FramePoses:
        """World poses of the links, the tool and the fingers."""
        tool = frames[-1]
        names = [f"link{k + 1}" for k in range(len(frames) - 2)] + ["tool"]
        poses = [*frames[1:-1], tool]
        for name, side in (("finger_left", 0.5), ("finger_right", -0.5)) if self.fingers is not None else ():
            finger = tool.copy()
            finger[:3, 3] += side * self.fingers.opening * tool[:3, 1]  # type: ignore[union-attr]
            names.append(name)
            poses.append(finger)
        return FramePoses(now, tuple(names), np.stack(poses))
