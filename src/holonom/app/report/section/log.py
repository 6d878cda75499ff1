"""Section: the log."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.report.parts import EventLog
from holonom.app.report.section_table import Section
from holonom.app.report.source import Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]


def _parts(source: Source) -> Sequence[EventLog]:
    return [EventLog(source.events, [robot.name for robot in source.robots if robot.name])]


SECTION = Method("the log", lambda _: Section(lambda source: bool(source.events), _parts), OWN)
