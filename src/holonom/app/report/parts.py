"""What sections of a report are made of: each part becomes one block of the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from holonom.app.report.drawing.curves import Curve, curves_html
from holonom.app.report.drawing.figures import Figures, figures_html
from holonom.app.report.findings.comparison import Comparison, comparison_html
from holonom.app.report.sections import LimitUse, PhotoOverlay, events_html, limits_html, photo_html
from holonom.signals import Event

__all__ = ["CurveGroup", "EventLog", "LimitTable", "Part", "curves_of", "part_html"]


@dataclass(frozen=True, slots=True)
class CurveGroup:
    """Plots over time; `name` is its place in the page."""

    curves: Sequence[Curve]
    name: str = "curves"
    title: str = "Curves"


@dataclass(frozen=True, slots=True)
class LimitTable:
    """Peaks of quantities against their limits, for joints or wheels by their names."""

    names: Sequence[str]
    uses: Sequence[LimitUse]
    name: str = "limits"
    title: str = "Limits touched"
    note: str = "Largest value of the run against its limit, at any 0.1 ms step: briefer than curves show."


@dataclass(frozen=True, slots=True)
class EventLog:
    """The log; `robots` are the names of those that its events may be of, where there are several."""

    events: Sequence[Event]
    robots: Sequence[str] = ()


Part = Comparison | CurveGroup | EventLog | Figures | LimitTable | PhotoOverlay


def part_html(part: Part) -> str:
    """The block; "" where there is nothing to show."""
    match part:
        case Comparison():
            return comparison_html(part)
        case CurveGroup():
            return curves_html(part.curves, part.name, part.title)
        case EventLog():
            return events_html(part.events, part.robots)
        case Figures():
            return figures_html(part)
        case LimitTable():
            return limits_html(part.names, part.uses, part.name, part.title, part.note)
        case PhotoOverlay():
            return photo_html(part)


def curves_of(parts: Sequence[Part]) -> tuple[Curve, ...]:
    """All curves that the page's script is to draw."""
    return tuple(curve for part in parts if isinstance(part, CurveGroup) for curve in part.curves)
