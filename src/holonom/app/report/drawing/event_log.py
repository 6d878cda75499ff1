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
"""Lines from which on those of several robots stand in groups."""


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
    """Lines, and for each event the number of its line: what a robot says again is no line of its own."""
    names = tuple(robots)
    rows: list[EventRow] = []
    numbers: list[int] = []
    latest: dict[str, EventRow] = {}
    for event in events:
        robot = robot_of(event, names)
        row = latest.get(robot)
        if row is not None and _said(row.event) == _said(event):
            row.count, row.last = row.count + 1, event.time
        else:
            row = latest[robot] = EventRow(len(rows), event, robot, 1, event.time)
            rows.append(row)
        numbers.append(row.number)
    return rows, numbers


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


def _said(event: Event) -> tuple[str, str, str, int]:
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
