"""A robot that only remembers what it was asked, for running programs against."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from holonom.errors import MotionError
from holonom.lang import Motion, Part, Program, Status, VmState, compile_program, start, step


@dataclass
class FakeMachine:
    """Each motion takes `motion_ticks`; at most `depth` motions wait or run; the hand takes `hand_ticks`.

    Measured joints lag behind the commanded ones by `sag`; the joints `slides` slide.
    """

    motion_ticks: int = 0
    depth: int = 2
    hand_ticks: int = 0
    reach: float = 10.0
    parts: list[Part] = field(default_factory=list)
    inputs: set[int] = field(default_factory=set)
    motions: list[Motion] = field(default_factory=list)
    log: list[tuple[object, ...]] = field(default_factory=list)
    said: list[tuple[str, int]] = field(default_factory=list)
    queue: list[int] = field(default_factory=list)
    hand: int = 0
    ticks: int = 0
    target: np.ndarray = field(default_factory=lambda: np.eye(4))
    arm: np.ndarray = field(default_factory=lambda: np.zeros(6))
    sag: float = 0.0
    slides: tuple[int, ...] = ()
    located: int = 0

    def tick(self) -> None:
        self.ticks += 1
        self.hand = max(0, self.hand - 1)
        if self.queue:
            self.queue[0] -= 1
            if self.queue[0] <= 0:
                self.queue.pop(0)

    def move(self, motion: Motion) -> bool:
        if motion.pose is not None and np.linalg.norm(motion.pose[:3, 3]) > self.reach:
            raise MotionError("out of reach")
        if len(self.queue) >= self.depth:
            return False
        if self.motion_ticks:
            self.queue.append(self.motion_ticks)
        self.motions.append(motion)
        self.log.append(("move", motion.line))
        if motion.pose is not None:
            self.target = motion.pose.copy()
        else:
            self.arm = motion.joints.copy()
        return True

    def idle(self) -> bool:
        return not self.queue

    def set_hand(self, closed: bool) -> None:
        self.hand = self.hand_ticks
        self.log.append(("hand", closed, self.idle()))

    def hand_idle(self) -> bool:
        return self.hand == 0

    def set_signal(self, number: int, on: bool) -> None:
        self.log.append(("signal", number, on))
        (self.inputs.add if on else self.inputs.discard)(number)

    def signal(self, number: int) -> bool:
        return number in self.inputs

    def picture(self) -> int:
        self.located = 0
        return len(self.parts)

    def locate(self, kind: str) -> Part | None:
        while self.located < len(self.parts):
            part = self.parts[self.located]
            self.located += 1
            if kind in ("", part.kind):
                return part
        return None

    def destination(self) -> np.ndarray:
        return self.target.copy()

    def turns(self) -> tuple[bool, ...]:
        return tuple(k not in self.slides for k in range(len(self.arm)))

    def goal(self) -> np.ndarray:
        return self.arm.copy()

    def joints(self) -> np.ndarray:
        return self.arm - self.sag

    def pose(self) -> np.ndarray:
        return np.full((4, 4), 7.0)

    def ready_joints(self) -> np.ndarray:
        return np.array([0.0, 1.0, -1.0, 0.0, 0.0, 0.0])

    def time(self) -> float:
        return self.ticks * 0.01

    def say(self, text: str, line: int) -> None:
        self.said.append((text, line))


def run(
    source: str | Program, machine: FakeMachine | None = None, *, ticks: int = 1000, **options: int
) -> tuple[FakeMachine, VmState]:
    """Run a program (a text may leave out .PROGRAM and .END) until it halts or pauses, or the ticks are over."""
    if isinstance(source, str):
        source = compile_program(wrap(source))
    machine = machine or FakeMachine()
    state = start(source)
    for _ in range(ticks):
        if step(source, state, machine, **options) in (Status.HALTED, Status.PAUSED):
            break
        machine.tick()
    return machine, state


def wrap(body: str) -> str:
    return body if ".PROGRAM" in body.upper() else f".PROGRAM main()\n{body}\n.END\n"


def said(source: str, machine: FakeMachine | None = None) -> list[str]:
    """Return the lines that a program typed."""
    return [text for text, _ in run(source, machine)[0].said]
