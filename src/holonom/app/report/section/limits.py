"""Section: the largest values of a run against their limits, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.findings.peaks import limit_uses
from holonom.app.report.parts import LimitGroups, LimitTable
from holonom.app.report.section_table import Section
from holonom.app.report.source import RobotSource, Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

MANY = 12
"""Rows of all robots from which on each has its table in a group of its own."""
SAMPLED = "Largest value among the recording's samples against its limit; what was briefer is not in it."


def _parts(source: Source) -> Sequence[LimitTable | LimitGroups]:
    tables = [(robot.name, table) for robot in source.robots if (table := _table(robot)).uses]
    if len(tables) > 1 and sum(len(table.names) for _, table in tables) > MANY:
        return [LimitGroups(tables)]
    return [table for _, table in tables]


def _table(robot: RobotSource) -> LimitTable:
    note = {} if robot.statistics else {"note": SAMPLED}
    return LimitTable(
        robot.facts.joints, limit_uses(robot), robot.key("limits"), robot.called("Limits touched"), **note
    )


def _applies(source: Source) -> bool:
    return any(robot.facts.limits for robot in source.robots)


SECTION = Method("peaks against limits", lambda _: Section(_applies, _parts), OWN)
