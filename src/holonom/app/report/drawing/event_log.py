"""The log of a page: repeated lines as one with a count, long logs of several robots in groups."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from holonom.app.recording.scope import bare
from holonom.app.report.markup import Html, html, joined
from holonom.signals import Event

__all__ = ["EventRow", "event_rows", "events_html", "robot_of"]

ROWS = 5000
"""Lines that the log shows."""
MANY = 60
"""Lines from which on those of several robots stand in groups, and loops are found."""
LOOP = 40
"""Lines of a loop at most."""
Said = tuple[str, str, str, int]
"""What makes two lines the same: level, source, text, program line."""


@dataclass(slots=True)
class EventRow:
    """A line of the log: an event, whose it is, how often it came, and when last."""

    number: int
    event: Event
    robot: str
    count: int
    last: float


def robot_of(event: Event, robots: Iterable[str]) -> str:
    """Name of the robot that an event is of, "" where it is of none of these, or of one that is alone."""
    return next((robot for robot in robots if robot and event.source.startswith(f"{robot}.")), "")


def event_rows(events: Sequence[Event], robots: Iterable[str] = ()) -> tuple[list[EventRow], list[int]]:
    """Lines, and for each event the number of its line.

    What a robot says again is no line of its own; nor, of a robot that says much, a loop of lines that comes again.
    """
    names = tuple(robots)
    own: dict[str, list[int]] = {}
    for k, event in enumerate(events):
        own.setdefault(robot_of(event, names), []).append(k)
    rows, numbers = dict[int, EventRow](), [0] * len(events)
    for robot, indices in own.items():
        firsts = _folded([_said(events[k]) for k in indices], LOOP if len(indices) > MANY else 1)
        for k, first in zip(indices, firsts, strict=True):
            row = rows.setdefault(indices[first], EventRow(0, events[indices[first]], robot, 0, 0.0))
            row.count, row.last, numbers[k] = row.count + 1, events[k].time, indices[first]
    ordered = sorted(rows)
    for number, first in enumerate(ordered):
        rows[first].number = number
    return [rows[first] for first in ordered], [rows[first].number for first in numbers]


def _folded(stated: Sequence[Said], longest: int) -> list[int]:
    """For each line the place of the one that it is shown as: its own, or where it stood in a loop that it repeats.

    Loops are of `longest` lines at most; lines that come again at once are one in them.
    """
    places: list[int] = []
    kept: list[int] = []
    k = 0
    while k < len(stated):
        for count in range(1, min(longest, len(kept)) + 1):
            again = _repeated(stated, k, kept[-count:])
            if again:
                places += again
                k += len(again)
                break
        else:
            places.append(k)
            kept.append(k)
            k += 1
    return places


def _repeated(stated: Sequence[Said], k: int, loop: Sequence[int]) -> list[int]:
    """Places in a loop of the lines from the k-th on that are all of it once more, each perhaps several times."""
    places: list[int] = []
    for place in loop:
        if k == len(stated) or stated[k] != stated[place]:
            return []
        while k < len(stated) and stated[k] == stated[place]:
            places.append(place)
            k += 1
    return places


def events_html(events: Sequence[Event], robots: Sequence[str] = ()) -> Html:
    """The log: time, robot of several, program line, text; a click moves the replay there. Of very many the first."""
    rows, _ = event_rows(events, robots)
    if not rows:
        return Html()
    shown = rows[:ROWS]
    more = html('<p class="note">The first {} of {} lines; the recording holds all.</p>', ROWS, len(rows))
    body = _groups(shown, robots) if robots and len(shown) > MANY else _table(shown, named=bool(robots))
    return html(
        '<section id="log" class="card"><h2>Events</h2>{}{}</section>', body, more if len(rows) > ROWS else Html()
    )


def _said(event: Event) -> Said:
    return event.level, event.source, event.text, event.line


def _groups(rows: Sequence[EventRow], robots: Sequence[str]) -> Html:
    """A table for each robot, and one for the cell; the first is open."""
    groups = [(name, [row for row in rows if row.robot == name]) for name in (*robots, "")]
    filled = [(name or "cell", group) for name, group in groups if group]
    return joined(
        html(
            '<details class="group"{}><summary>{} <small>{} lines</small></summary>{}</details>',
            Html(" open" if k == 0 else ""), name, len(group), _table(group, named=False),
        )
        for k, (name, group) in enumerate(filled)
    )  # fmt: skip


def _table(rows: Sequence[EventRow], *, named: bool) -> Html:
    return html(
        '<div class="scroll"><table class="events"><thead><tr><th>time&nbsp;s</th><th>line</th>{}<th>source</th>'
        "<th>event</th></tr></thead><tbody>{}</tbody></table></div>",
        Html("<th>robot</th>" if named else ""),
        joined(_row(row, named=named) for row in rows),
    )


def _row(row: EventRow, *, named: bool) -> Html:
    e = row.event
    often = html(' <small class="often">× {}, to {:.2f} s</small>', row.count, row.last) if row.count > 1 else Html()
    return html(
        '<tr class="{}" data-time="{:.3f}" data-row="{}"><td>{:.2f}</td><td>{}</td>{}<td>{}</td><td>{}{}</td></tr>',
        e.level, e.time, row.number, e.time, e.line or "", html("<td>{}</td>", row.robot) if named else Html(),
        bare(e.source, row.robot, "."), e.text, often,
    )  # fmt: skip
