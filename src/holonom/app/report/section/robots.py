"""Section: what each robot is, what drives and controls it, and what was assumed."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.drawing.figures import Figures, Table
from holonom.app.report.findings.headline import headline_of
from holonom.app.report.section_table import Section
from holonom.app.report.source import RobotSource, Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

HEAD = ("robot", "model", "drives", "controller")


def _parts(source: Source) -> Sequence[Figures]:
    rows = [_row(robot, alone=source.alone) for robot in source.robots]
    head = HEAD if source.alone else (*HEAD, "what came of it")
    return [Figures("robots", "Robots", [Table(head, rows)], notes=source.cell.notes)]


def _row(robot: RobotSource, *, alone: bool) -> tuple[str, ...]:
    facts = robot.facts
    called = f"{facts.name} ({facts.kind})" if facts.name else facts.kind
    row = (called, facts.model, facts.drives.replace("_", " "), facts.controller.replace("_", " "))
    came = "; ".join(f"{label} {value}" for label, value in headline_of(robot).items() if label != "Controller")
    return row if alone else (*row, came)


def _applies(source: Source) -> bool:
    return source.told


SECTION = Method("models, drives, controllers, and what was assumed", lambda _: Section(_applies, _parts), OWN)
