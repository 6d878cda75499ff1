"""What is written for an arm: its table of the cell, and a program that moves it about its home."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterator
from pathlib import Path

from holonom.app.cell.build.arm import usual_home
from holonom.app.start.text import angle, length, listed, quoted, round_down, rows
from holonom.errors import ModelError
from holonom.machine.arm.servos import check_drives
from holonom.model import PRESETS, ArmModel, Joint, JointLimits, reach
from holonom.model.load import found_model

__all__ = ["PROGRAM", "ArmStart", "arm_starts", "source_of"]

PROGRAM = "main.arps"
TURN = math.radians(15)
"""What a joint turns by, where its limits leave it so much."""
STEP = 0.05
"""Length of a straight line over the arm's reach."""
LINES = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, -1), (-1, 0, 0), (0, -1, 0))
"""Directions that a straight line is tried in."""
BENT = math.radians(45)


@dataclasses.dataclass(frozen=True, slots=True)
class ArmStart:
    """An arm as its first cell has it: `model` and its source, home (rad, m), direction of a straight line or none."""

    source: str
    model: ArmModel
    home: tuple[float, ...]
    line: tuple[int, int, int] | None

    def table(self, name: str = "", on: str = "") -> str:
        """Return its `[[robot]]`; `on` names what it stands on."""
        joints = [self.model.joints[i] for i in self.model.independent]
        home = listed(_value(joint, q) for joint, q in zip(joints, self.home, strict=True))
        own = [("[[robot]]", "one such table for each robot")]
        own += [(f"name = {quoted(name)}", "its joints, frames and topics begin with it")] if name else []
        own += [(f"model = {quoted(self.source)}", "'holonom methods presets' lists them; or a .urdf or .xacro file")]
        own += [(f"on = {quoted(on)}", "it stands on that robot, at that frame")] if on else []
        own += [
            (f"home = {home}", f"where it starts and READY goes: {', '.join(joint.name for joint in joints)}"),
            *self._drives(),
            (f"program = {quoted(PROGRAM)}", "what it does"),
            ("[robot.limits]", "what this cell allows it"),
            ("joint_speed = 0.5", "of its joints' greatest speeds, at 100 % in the program"),
            ('line_speed = "250mm/s"', "of its tool on straight lines, at 100 %"),
        ]
        return rows(own)

    def _drives(self) -> list[tuple[str, str]]:
        if _has_motors(self.model):
            return [
                ('# drives = "ideal"', "without it: the motors, gears and encoders that its model states"),
                ('controllers = ["computed_torque"]', 'or "cascade"; with both the report compares them'),
            ]
        said = 'joints follow within their limits; "from_limits": motors are sized and simulated'
        return [('drives = "ideal"', said)]

    def program(self, signals: tuple[int, int] | None = None) -> str:
        """Return the ARPS program; with `signals` it switches the first on half-way and waits for the second."""
        lines = [(".PROGRAM main()", ""), *self._turns(), ("  READY", "to home, all joints arriving together")]
        if signals:
            lines += [
                ("  BREAK", "wait until the arm is at rest"),
                (f"  SIGNAL {signals[0]}", "the base begins to drive"),
                (f"  WAIT SIG({signals[1]})", "it has arrived"),
            ]
        lines += [*self._straight(), ('  TYPE "done"', "a line for the operator"), (".END", "")]
        return f"; The first program of a file runs. Lengths are mm, angles degrees.\n\n{rows(lines, ';')}"

    def _turns(self) -> Iterator[tuple[str, str]]:
        """Turn the first two joints that turn; one that slides is left to the line."""
        joints = [(k, i, self.model.joints[i]) for k, i in enumerate(self.model.independent)]
        for k, i, joint in [entry for entry in joints if entry[2].turns][:2]:
            by = math.degrees(_turn(self.model.limits(i), self.home[k]))
            yield f"  DRIVE {k + 1}, {by:.4g}, 50", f"turn joint {k + 1}, {joint.name}, by {by:.4g} degrees at 50 %"

    def _straight(self) -> Iterator[tuple[str, str]]:
        if self.line is None:
            return
        step = 1e3 * round_down(STEP * reach(self.model))
        yield f"  SPEED {2 * step:g} MMPS ALWAYS", "of the straight lines that follow"
        for sign, said in ((1, "by x, y, z along the axes of its base"), (-1, "and back")):
            yield f"  DRAW {', '.join(f'{sign * step * part + 0.0:g}' for part in self.line)}", said


def arm_starts(source: str, model: ArmModel) -> Iterator[ArmStart]:
    """Yield what an arm might begin with, the best first; whether it can do the straight line has to be tried."""
    homes = list(_homes(model))
    for home in homes:
        for line in LINES:
            yield ArmStart(source, model, home, line)
    yield ArmStart(source, model, homes[0], None)


def source_of(name: str, folder: Path) -> tuple[str, ArmModel]:
    """Return what a cell in a folder calls an arm, a preset's name or the path of a file, and the arm.

    The file stays where it is, as it may read others. Its path is relative to the folder, unless they have nothing but
    the root in common.

    Raises
    ------
    InputError
        No such preset; a file that is missing or no arm.
    """
    try:
        model = found_model(name)
    except ModelError as problem:
        if "$(find" not in str(problem):
            raise
        raise ModelError(f"{problem}; a cell names no packages: expand the file to a .urdf first") from None
    if name in PRESETS:
        return name, model
    file, folder = Path(name).resolve(), folder.resolve()
    common = Path(os.path.commonpath([file, folder]))
    return (str(file) if common == Path(common.anchor) else os.path.relpath(file, folder)), model


def _homes(model: ArmModel) -> Iterator[tuple[float, ...]]:
    """Poses that the model names; where there are none, the usual home, and one that is bent, where lines go better."""
    named = [model.poses[name] for name in ("nominal", "home", "ready") if name in model.poses]
    if named:
        yield named[0]
        return
    usual = usual_home(model)
    yield usual
    joints = [model.joints[i] for i in model.independent]
    limits = [model.limits(i) for i in model.independent]
    for sign in (1, -1):
        bent = [sign * BENT * (1 - 2 * (k % 2)) if joint.turns else q
                for k, (joint, q) in enumerate(zip(joints, usual, strict=True))]  # fmt: skip
        yield tuple(_within(bounds, q) for bounds, q in zip(limits, bent, strict=True))


def _within(limits: JointLimits, q: float) -> float:
    lower, upper = limits.lower, limits.upper
    return min(max(q, 0.9 * lower + 0.1 * upper), 0.1 * lower + 0.9 * upper) if math.isfinite(upper - lower) else q


def _turn(limits: JointLimits, q: float) -> float:
    """By what a joint is turned: half of the room to the farther of its limits at most."""
    up, down = limits.upper - q, q - limits.lower
    return math.copysign(min(TURN, 0.5 * max(up, down)), 1 if up >= down else -1)


def _value(joint: Joint, q: float) -> str:
    return angle(q) if joint.turns else length(q)


def _has_motors(model: ArmModel) -> bool:
    try:
        check_drives(model)
    except ModelError:
        return False
    return model.bodies is not None
