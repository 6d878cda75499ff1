"""The first example's arm, plant and machines, so that no other kernels are compiled for these tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.closed_loop import ArmLoop, SimulatedArm
from holonom.lang import Configuration, Motion, Part, Program, Status, start, step
from holonom.machine import ArmMachine, ControlSettings, DryMachine
from holonom.sim import Disc, Fingers, Gripper, Ground, Surface, World
from holonom.spatial import pose

FILE = Path(__file__).resolve().parents[2] / "examples" / "01_sort_coins" / "cell.toml"
JOB = build_job(load_cell(FILE), FILE).arms[0]
ARM, HOME = JOB.arm, JOB.home
DOWN = np.diag([1.0, -1.0, -1.0])
LINES = JOB.line


class ListSink:
    """Keeps every record."""

    def __init__(self) -> None:
        self.records: list[object] = []

    def put(self, record: object) -> None:
        self.records.append(record)

    def of(self, kind: type) -> list:
        return [record for record in self.records if isinstance(record, kind)]


def tool_down(x: float, y: float, z: float) -> np.ndarray:
    return pose((x, y, z), DOWN)


def make_loop(controller: str = "computed_torque", q: np.ndarray = HOME, ground: Ground = Ground()) -> ArmLoop:
    return ArmLoop(ARM, q, ControlSettings(controller), ground)


def stand(loop: ArmLoop, q: np.ndarray, seconds: float) -> None:
    """Hold a reference."""
    still = np.zeros((100, 6))
    reference = np.stack([np.tile(q, (100, 1)), still, still])
    for _ in range(round(10 * seconds)):
        loop.advance(reference)


def make_hand(discs: Sequence[Disc] = ()) -> Fingers:
    table = Surface("table", pose((0.6, 0.0, 0.3)), (0.4, 0.6))
    tray = Surface("tray", pose((0.7, 0.2, 0.302)), (0.2, 0.2))
    return Fingers(World([table, tray], discs), Gripper(0.035, 0.008, 0.002, 0.35))


def make_disc(x: float, y: float, name: str = "coin_01", radius: float = 0.01, thickness: float = 0.0025) -> Disc:
    return Disc(name, radius, thickness, 0.0068, pose((x, y, 0.3 + thickness / 2)))


def make_arm(
    hand: Fingers | None = None, parts: Sequence[Part] = (), controller: str = "computed_torque"
) -> tuple[SimulatedArm, ListSink]:
    sink = ListSink()
    loop, hand = make_loop(controller), hand or make_hand()
    return SimulatedArm(loop, hand, sink, look=lambda: parts, ready=HOME, line=LINES), sink


def make_dry(parts: Sequence[Part] = ()) -> DryMachine:
    return DryMachine(ARM, HOME, look=lambda: parts, ready=HOME, line=LINES, hand_time=0.1)


def motion(to: np.ndarray, *, kind: str = "joint", blend: bool = True, line: int = 1, **changes: object) -> Motion:
    """A motion to joints (6,) or a tool pose (4, 4)."""
    settings = {"speed": 1.0, "speed_mps": None, "acceleration": 1.0, "tolerance": "fine"} | changes
    target, joints = (to, None) if to.ndim == 2 else (None, to)
    return Motion(kind, target, joints, configuration=Configuration(), blend=blend, line=line, **settings)


def run_simulated(program: Program, machine: ArmMachine, seconds: float = 20.0) -> None:
    state = start(program)
    while machine.time() < seconds:
        status = step(program, state, machine)
        machine.advance()
        if status is Status.HALTED and machine.idle():
            return
    raise AssertionError("the program did not end")


def run_dry(program: Program, machine: DryMachine) -> None:
    state = start(program)
    while step(program, state, machine) is not Status.HALTED:
        machine.tick()
