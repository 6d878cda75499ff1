"""Section: what each robot is, what drives and controls it, and what was assumed."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.figures import Figures, Table
from holonom.app.report.section_table import Section
from holonom.app.report.source import Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

HEAD = ("robot", "model", "drives", "controller")


def _parts(source: Source) -> Sequence[Figures]:
    rows = [
        (
            f"{robot.name} ({robot.kind})" if robot.name else robot.kind,
            robot.model,
            robot.drives.replace("_", " "),
            robot.controller.replace("_", " "),
        )
        for robot in source.cell.robots
    ]
    return [Figures("robots", "Robots", [Table(HEAD, rows)], " ".join(source.cell.notes))]


def _applies(source: Source) -> bool:
    return source.told


SECTION = Method("models, drives, controllers, and what was assumed", lambda _: Section(_applies, _parts), OWN)
