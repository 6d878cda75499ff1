"""Section: the largest values of a run against their limits, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.findings.peaks import limit_uses
from holonom.app.report.parts import LimitTable
from holonom.app.report.section_table import Section
from holonom.app.report.source import Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

SAMPLED = "Largest value among the recording's samples against its limit; what was briefer is not in it."


def _parts(source: Source) -> Sequence[LimitTable]:
    tables = []
    for robot in source.robots:
        uses = limit_uses(robot)
        note = {} if robot.statistics else {"note": SAMPLED}
        if uses:
            named = robot.key("limits"), robot.called("Limits touched")
            tables.append(LimitTable(robot.facts.joints, uses, *named, **note))
    return tables


def _applies(source: Source) -> bool:
    return any(robot.facts.limits for robot in source.robots)


SECTION = Method("peaks against limits", lambda _: Section(_applies, _parts), OWN)
