"""Section: the log."""

from __future__ import annotations

from holonom.app.report.parts import EventLog
from holonom.app.report.section_table import Section
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

SECTION = Method("the log", lambda _: Section(lambda s: True, lambda s: [EventLog(s.events)]), OWN)
