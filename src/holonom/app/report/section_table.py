"""The sections of a report below its replay, in their order: a new one is a file and a line here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from holonom.app.report.parts import Part, Unshown, stated
from holonom.app.report.source import Source
from holonom.registry import Table

__all__ = ["REPORT_SECTIONS", "Section", "parts_of"]


@dataclass(frozen=True, slots=True)
class Section:
    """Whether it is for such a source at all, and what it shows of it, which may still be nothing."""

    applies: Callable[[Source], bool]
    parts: Callable[[Source], Sequence[Part]]


REPORT_SECTIONS = Table(
    "report_sections",
    "section of a report",
    "a `Section`: whether it applies to a recording, and its parts",
    {
        "missing": "holonom.app.report.section.missing:SECTION",
        "robots": "holonom.app.report.section.robots:SECTION",
        "comparison": "holonom.app.report.section.comparison:SECTION",
        "path": "holonom.app.report.section.path:SECTION",
        "faults": "holonom.app.report.section.faults:SECTION",
        "polar": "holonom.app.report.section.polar:SECTION",
        "base": "holonom.app.report.section.base:SECTION",
        "base_curves": "holonom.app.report.section.base_curves:SECTION",
        "curves": "holonom.app.report.section.curves:SECTION",
        "photograph": "holonom.app.report.section.photograph:SECTION",
        "limits": "holonom.app.report.section.limits:SECTION",
        "log": "holonom.app.report.section.log:SECTION",
    },
)


def parts_of(source: Source) -> list[Part]:
    """All parts of the sections that apply; what goes wrong in one of them is said in its place."""
    return [part for name in REPORT_SECTIONS for part in _parts(name, source)]


def _parts(name: str, source: Source) -> Sequence[Part]:
    try:
        section: Section = REPORT_SECTIONS.make(name)
        return section.parts(source) if section.applies(source) else ()
    except Exception as error:  # whatever it is, the rest of the report is worth having
        return [Unshown(name, stated(error))]
