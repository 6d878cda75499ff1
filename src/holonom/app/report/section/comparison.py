"""Section: how well an arm kept to its tool path under several controllers."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.findings.comparison import Comparison
from holonom.app.report.findings.tracking import compared
from holonom.app.report.section_table import Section
from holonom.app.report.source import Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]


def _parts(source: Source) -> Sequence[Comparison]:
    return [found for robot in source.robots if (found := compared(robot)) is not None]


def _applies(source: Source) -> bool:
    return any(robot.beside and robot.facts.kind == "arm" for robot in source.robots)


SECTION = Method("two controllers on one path", lambda _: Section(_applies, _parts), OWN)
