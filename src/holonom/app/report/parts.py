"""What sections of a report are made of: each part becomes one block of the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from holonom.app.report.drawing.curves import Curve, curves_html
from holonom.app.report.drawing.event_log import events_html
from holonom.app.report.drawing.figures import Figures, figures_html
from holonom.app.report.drawing.limit_table import LimitGroups, LimitTable, limit_groups_html, limits_html
from holonom.app.report.findings.comparison import Comparison, comparison_html
from holonom.app.report.markup import Html, html
from holonom.app.report.sections import PhotoOverlay, photo_html
from holonom.signals import Event

__all__ = [
    "CurveGroup",
    "EventLog",
    "LimitGroups",
    "LimitTable",
    "Part",
    "Unshown",
    "curves_of",
    "drawn",
    "part_html",
    "stated",
]


@dataclass(frozen=True, slots=True)
class CurveGroup:
    """Plots over time; `name` is its place in the page."""

    curves: Sequence[Curve]
    name: str = "curves"
    title: str = "Curves"


@dataclass(frozen=True, slots=True)
class EventLog:
    """The log; `robots` are the names of those that its events may be of, where there are several."""

    events: Sequence[Event]
    robots: Sequence[str] = ()
    name: str = "log"


@dataclass(frozen=True, slots=True)
class Unshown:
    """A section that could not be made, by its name, and why."""

    name: str
    why: str


Part = Comparison | CurveGroup | EventLog | Figures | LimitGroups | LimitTable | PhotoOverlay | Unshown


def part_html(part: Part) -> Html:
    """The block; "" where there is nothing to show."""
    match part:
        case Comparison():
            return comparison_html(part)
        case CurveGroup():
            _check(part)
            return curves_html(part.curves, part.name, part.title)
        case EventLog():
            return events_html(part.events, part.robots)
        case Figures():
            return figures_html(part)
        case LimitGroups():
            return limit_groups_html(part)
        case LimitTable():
            return limits_html(part)
        case PhotoOverlay():
            return photo_html(part)
        case Unshown():
            return _unshown(part)


def drawn(part: Part) -> tuple[Part, Html]:
    """A part and its block; of one that cannot be drawn a line that says so, and why."""
    try:
        return part, part_html(part)
    except Exception as error:  # whatever it is, the rest of the page is worth having
        lost = Unshown(getattr(part, "name", "photograph"), stated(error))
        return lost, part_html(lost)


def stated(error: Exception) -> str:
    """What went wrong, in a line."""
    return f"{type(error).__name__}: {error}".splitlines()[0]


def curves_of(parts: Sequence[Part]) -> tuple[Curve, ...]:
    """All curves that the page's script is to draw."""
    return tuple(curve for part in parts if isinstance(part, CurveGroup) for curve in part.curves)


def _check(group: CurveGroup) -> None:
    """Of what the page's script is to draw nothing may be missing."""
    for curve in group.curves:
        if curve.values.shape != (len(curve.time), len(curve.names)):
            raise ValueError(
                f"curve {curve.key!r} has {len(curve.time)} times and {len(curve.names)} names for values of shape "
                f"{curve.values.shape}"
            )


def _unshown(part: Unshown) -> Html:
    return html(
        '<section id="{0}" class="card unshown"><h2>{0}</h2><p class="note">This section could not be made ({1}). '
        "The rest of the report does not depend on it.</p></section>",
        part.name, part.why,
    )  # fmt: skip
