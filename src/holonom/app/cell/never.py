"""What a cell asks for that can never happen: longer than its time limit, after a signal that nobody gives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from holonom.app.cell.load import place_in
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.robot import Robot
from holonom.app.cell.rehearse import switches_signals
from holonom.app.job import ArmJob, BaseJob
from holonom.errors import CellError

__all__ = ["refuse_never", "too_late"]


def refuse_never(cell: Cell, path: Path, arms: Sequence[ArmJob], bases: Sequence[BaseJob]) -> None:
    """Refuse what cannot happen in a run of the cell in the file `path`.

    Raises
    ------
    CellError
        A line each, with file, line and key.
    """
    found = [*_long(cell, path, bases), *_unheard(cell, path, arms, bases)]
    if found:
        raise CellError("\n".join(found))


def too_late(cell: Cell) -> Iterator[str]:
    """Say of events and faults that they come after the run's last moment."""
    limit = cell.cell.time_limit
    events = [(f"event of signal {event.signal}" if event.signal else "payload", event.at) for event in cell.event]
    for what, at in (*events, *((f"fault of {fault.wheel}", fault.time) for fault in cell.fault)):
        if at > limit:
            yield f"{what} at {at:g} s: the cell's time_limit is {limit:g} s"


def _long(cell: Cell, path: Path, bases: Sequence[BaseJob]) -> Iterator[str]:
    limit = cell.cell.time_limit
    ends = {base.name: base.task.end for base in bases}
    for robot in cell.robot:
        end = (robot.hold or 0.0) if robot.is_arm else ends[robot.name]
        if end > limit:
            of = f" of {robot.name}" if robot.name else ""
            what = next(key for key in ("path", "velocity", "hold") if getattr(robot, key) is not None)
            yield (
                f"{place_in(path, 'cell', 'time_limit')}: the {what}{of} takes until "
                f"{end:.1f} s; time_limit is {limit:g} s: raise it, or shorten the {what}"
            )


def _unheard(cell: Cell, path: Path, arms: Sequence[ArmJob], bases: Sequence[BaseJob]) -> Iterator[str]:
    """Tasks that wait for a signal which no event, other base or program switches on."""
    if any(switches_signals(arm.program) for arm in arms):
        return
    waits = {base.name: base.task.after for base in bases}
    for number, robot in enumerate(cell.robot):
        after = waits.get(robot.name)
        if after is not None and after not in _given(cell, bases, robot):
            yield (
                f"{place_in(path, 'robot', number, 'start')}: it waits for signal {after}, which no event, other base "
                "or program switches on; add an [[event]], or the `done` of another base"
            )


def _given(cell: Cell, bases: Sequence[BaseJob], robot: Robot) -> set[int | None]:
    events = {event.signal for event in cell.event if event.signal is not None and event.on}
    return events | {base.task.done for base in bases if base.name != robot.name}
