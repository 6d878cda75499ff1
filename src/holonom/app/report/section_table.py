"""The sections of a report below its replay, in their order: a new one is a function and a line here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from holonom.app.recording import Recording
from holonom.app.report.comparison import Comparison, comparison_html
from holonom.app.report.curves import Curve, curves_html
from holonom.app.report.figures import Figures, figures_html
from holonom.app.report.sections import LimitUse, PhotoOverlay, events_html, limits_html, photo_html
from holonom.registry import OWN, Method, Table

__all__ = ["REPORT_SECTIONS", "Content", "sections_html"]


@dataclass(frozen=True, slots=True)
class Content:
    """What sections are made of: the recording, and what was handed in beside it."""

    recording: Recording
    curves: Sequence[Curve]
    figures: Sequence[Figures]
    limits: Sequence[LimitUse]
    photograph: PhotoOverlay | None
    comparison: Comparison | None


Section = Callable[[Content], str]


def _line(help: str, section: Section) -> Method:
    return Method(help, lambda _: section, OWN)


REPORT_SECTIONS = Table(
    "report_sections",
    "section of a report",
    "a function of the `Content` that gives HTML, empty where there is nothing to show",
    {
        "comparison": _line("two controllers on one path", lambda c: comparison_html(c.comparison)),
        "figures": _line("maps, polar plots and tables", lambda c: "".join(figures_html(group) for group in c.figures)),
        "curves": _line("lines over time", lambda c: curves_html(c.curves)),
        "photograph": _line("what the camera saw", lambda c: photo_html(c.photograph)),
        "limits": _line("peaks against limits", lambda c: limits_html(c.recording.joint_names, c.limits)),
        "events": _line("the log", lambda c: events_html(c.recording.events)),
    },
)


def sections_html(content: Content) -> str:
    """All sections that have something to show."""
    made: list[Section] = [REPORT_SECTIONS.make(name) for name in REPORT_SECTIONS]
    return "\n".join(section(content) for section in made)
