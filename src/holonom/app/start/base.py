"""What is written for a mobile base: its wheels with the examples of their table, and a way to drive."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from holonom.app.cell.build.base import unsimulated
from holonom.app.start.text import angle, length, quoted, rows
from holonom.errors import InputError, UnknownName
from holonom.mobile.base.drivable import skids
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.methods import ARRANGEMENTS
from holonom.registry import Field

__all__ = ["BaseStart", "base_starts", "runnable"]

Rows = list[tuple[str, str]]

SMALLEST = 0.6
"""m, diameter of a circle that is driven first."""
ROOM = 3.0
"""Diameter of that circle over the distance of the farthest wheel, where wheels steer or skid."""


def _circle(base: WheelBase, scale: float) -> Rows:
    """A circle that the wheels can be steered around."""
    turns = any(wheel.kind in ("steered", "skid") for wheel in base.wheels)
    size = max(SMALLEST, ROOM * scale * max(wheel.l for wheel in base.wheels) if turns else 0.0)
    slow = skids(base.wheels)
    speed = 0.3 if slow else round(math.sqrt(SMALLEST * size), 1)
    heading = "tangent" if np.isfinite(base.turning_radius) else "fixed"
    return [
        ("[robot.path]", "or `velocity`, or `hold`"),
        ('shape = "circle"', "'holonom methods paths' lists them"),
        (f"size = {quoted(length(math.ceil(10.0 * size) / 10.0))}", "its diameter"),
        (f'speed = "{speed:g}m/s"', "the greatest on it"),
        (f'acceleration = "{speed:g}m/s2"', "the greatest on it, along and across together"),
        (f'heading = "{heading}"', 'it looks along the path ("tangent"), or the same way ("fixed")'),
    ]


AHEAD: Rows = [
    ("[robot.path]", "or `velocity`, or `hold`"),
    ('shape = "waypoints"', "'holonom methods paths' lists them"),
    ('points = [["0m", "0m"], ["0.5m", "0m"]]', "x forwards, y to the left"),
    ('speed = "0.4m/s"', "the greatest on it"),
    ('acceleration = "0.4m/s2"', "the greatest on it, along and across together"),
]
VELOCITIES: Rows = [
    ("velocity = [", "or a [robot.path], or `hold`"),
    ('  { at = "0s", vx = "0.3m/s" },', "forwards; vy: to the left, w: turning"),
    ('  { at = "2s" },', "and stops"),
    ("]", ""),
]


@dataclasses.dataclass(frozen=True, slots=True)
class BaseStart:
    """A base as its first cell has it: arrangement, what its lengths are multiplied by, its mass (kg), its task.

    It waits for a signal and gives another where there are two `signals`.
    """

    arrangement: str
    task: Rows
    scale: float = 1.0
    mass: float = 20.0
    signals: tuple[int, int] | None = None

    def table(self, name: str = "") -> str:
        """Return its `[[robot]]`."""
        own: Rows = [("[[robot]]", "one such table for each robot; x forwards, y to the left")]
        own += [(f"name = {quoted(name)}", "its wheels, frames and topics begin with it")] if name else []
        own += [(f"arrangement = {quoted(self.arrangement)}", "'holonom methods arrangements' lists them")]
        own += [
            (f"{field.name} = {_written(given, field, self.scale)}", field.parameter.meaning)
            for field, given in _examples(self.arrangement)
        ]
        own += [
            (f'mass = "{self.mass:g}kg"', "with wheels and motors"),
            ('drives = "from_limits"', 'motors are sized for its task; "ideal": wheels follow'),
        ]
        if self.signals:
            own += [
                (f"start = {{ signal = {self.signals[0]} }}", "it begins when this signal goes on; or at a time"),
                (f"done = {self.signals[1]}", "it switches this signal on at the end"),
            ]
        return rows([*own, *self.task])


def base_starts(
    arrangement: str, *, scale: float = 1.0, mass: float = 20.0, signals: tuple[int, int] | None = None
) -> Iterator[BaseStart]:
    """Yield what a base might begin with, the best first; whether its wheels can has to be tried.

    Raises
    ------
    UnknownName
        No such arrangement.
    InputError
        One that cannot be simulated yet.
    """
    _check(arrangement)
    first = AHEAD if signals else _circle(_example(arrangement), scale)
    for task in (first, VELOCITIES):
        yield BaseStart(arrangement, task, scale, mass, signals)


def runnable() -> tuple[str, ...]:
    """Return the arrangements that can be simulated."""
    return tuple(name for name in ARRANGEMENTS if _why_not(name) is None)


def _check(arrangement: str) -> None:
    if arrangement not in ARRANGEMENTS:
        raise UnknownName("arrangement of wheels", arrangement, runnable())
    why = _why_not(arrangement)
    if why is not None:
        raise InputError(
            f"arrangement {arrangement!r} cannot be simulated yet: {why}; there is {', '.join(runnable())}"
        )


def _why_not(arrangement: str) -> str | None:
    """Why an arrangement cannot run with the examples of its table, None where it can."""
    try:
        base = _example(arrangement)
    except InputError as problem:
        return str(problem)
    return unsimulated(base)


def _example(arrangement: str) -> WheelBase:
    found: WheelBase = ARRANGEMENTS.make(arrangement, {field.name: given for field, given in _examples(arrangement)})
    return found


def _examples(arrangement: str) -> list[tuple[Field, Any]]:
    """The parameters that the table has examples of, with them."""
    fields = ARRANGEMENTS[arrangement].fields
    return [(field, field.parameter.example) for field in fields if field.parameter.example is not None]


def _written(value: Any, field: Field, scale: float) -> str:
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(_written(entry, field, scale) for entry in value)}]"
    if field.parameter.unit == "m":
        return quoted(length(math.ceil(100.0 * scale * value - 1e-9) / 100.0))
    return quoted(angle(value)) if field.parameter.unit == "rad" else f"{value:g}"
