"""Sections of the report that need no script: facts, limits, photograph, events."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from holonom.app.recording.scope import bare
from holonom.arrays import Array
from holonom.signals import Event

__all__ = [
    "Detection",
    "LimitUse",
    "Outcome",
    "PhotoOverlay",
    "events_html",
    "facts_html",
    "limits_html",
    "photo_html",
    "programs_html",
    "robot_of",
]

ROWS = 5000
"""Events that the log shows."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """How the run ended: `ok`, and one line that says it."""

    ok: bool
    text: str


@dataclass(frozen=True, slots=True)
class LimitUse:
    """Peak of a quantity per joint against its limit, (n,) each, in `unit`, absolute values; NaN: not known."""

    quantity: str
    unit: str
    peak: Array
    limit: Array


@dataclass(frozen=True, slots=True)
class Detection:
    """A part that the camera found.

    Attributes
    ----------
    u, v, diameter
        Centre and diameter on the photograph, px.
    group
        Its class, a key of `PhotoOverlay.groups`.
    x, y, size
        Centre in the table frame and diameter, m.
    frame
        Its frame in the recording.
    """

    u: float
    v: float
    diameter: float
    group: str
    x: float
    y: float
    size: float
    frame: str


@dataclass(frozen=True, slots=True)
class PhotoOverlay:
    """The photograph (PNG file as bytes, width and height in pixels) and what was found on it.

    `groups` gives each group its colour, in the order of the legend; detections are numbered from 1.
    """

    png: bytes
    width: int
    height: int
    detections: tuple[Detection, ...]
    groups: Mapping[str, str]
    caption: str = ""


def facts_html(facts: Mapping[str, str]) -> str:
    """The run in a few numbers: label and value."""
    items = "".join(f"<div><dt>{escape(label)}</dt><dd>{escape(value)}</dd></div>" for label, value in facts.items())
    return f'<dl class="facts">{items}</dl>' if facts else ""


def limits_html(joint_names: Sequence[str], limits: Iterable[LimitUse], name: str, title: str, note: str) -> str:
    """A table, joints down and quantities across, each cell a bar from nothing to its limit."""
    uses = tuple(limits)
    if not uses:
        return ""
    head = "".join(f"<th>{escape(use.quantity)} <small>{escape(use.unit)}</small></th>" for use in uses)
    rows = "".join(
        f"<tr><th>{escape(joint)}</th>{''.join(_limit_cell(use, i) for use in uses)}</tr>"
        for i, joint in enumerate(joint_names)
    )
    return _section(
        name,
        title,
        f'<table class="limits"><thead><tr><th></th>{head}</tr></thead><tbody>{rows}</tbody></table>'
        f'<p class="note">{escape(note)}</p>',
    )


def photo_html(photo: PhotoOverlay | None) -> str:
    """The photograph with a numbered circle on every part found."""
    if photo is None:
        return ""
    marks = "".join(_mark(i, part, photo) for i, part in enumerate(photo.detections, start=1))
    counts = {group: sum(part.group == group for part in photo.detections) for group in photo.groups}
    legend = "".join(
        f'<li><i style="background:{escape(colour)}"></i>{escape(group)} <b>{counts[group]}</b></li>'
        for group, colour in photo.groups.items()
    )
    image = base64.b64encode(photo.png).decode()
    caption = f'<p class="note">{escape(photo.caption)}</p>' if photo.caption else ""
    return _section(
        "photograph",
        "What the camera saw",
        f'<figure class="photo" style="aspect-ratio:{photo.width}/{photo.height}">'
        f'<img id="photo" alt="photograph of the table" src="data:image/png;base64,{image}">'
        f'<svg viewBox="0 0 {photo.width} {photo.height}" role="img" aria-label="parts found">{marks}</svg></figure>'
        f'<div class="found"><div class="scroll">{_parts_table(photo)}</div></div>'
        f'<ul class="legend">{legend}</ul>{caption}',
    )


def robot_of(event: Event, robots: Iterable[str]) -> str:
    """Name of the robot that an event is of, "" where it is of none of these, or of one that is alone."""
    return next((robot for robot in robots if robot and event.source.startswith(f"{robot}.")), "")


def events_html(events: Sequence[Event], robots: Sequence[str] = ()) -> str:
    """The log: time, robot of several, program line, text; a click moves the replay there. Of very many the first."""
    shown = [(e, robot_of(e, robots)) for e in events[:ROWS]]
    rows = "".join(
        f'<tr class="{escape(e.level)}" data-time="{e.time:.3f}"><td>{e.time:.2f}</td><td>{e.line or ""}</td>'
        f"{f'<td>{escape(robot)}</td>' if robots else ''}"
        f"<td>{escape(bare(e.source, robot, '.'))}</td><td>{escape(e.text)}</td></tr>"
        for e, robot in shown
    )
    body = (
        '<div class="scroll"><table class="events"><thead><tr><th>time&nbsp;s</th><th>line</th>'
        f"{'<th>robot</th>' if robots else ''}<th>source</th><th>event</th></tr></thead>"
        f"<tbody>{rows}</tbody></table></div>"
    )
    if len(events) > ROWS:
        body += f'<p class="note">The first {ROWS} of {len(events)} events; the recording holds all.</p>'
    return _section("log", "Events", body if events else '<p class="note">No events were recorded.</p>')


def programs_html(programs: Mapping[str, str]) -> str:
    """The programs by their robots, line by line; the script marks the lines that run."""
    return "".join(_program(robot, text) for robot, text in programs.items() if text)


def _program(robot: str, text: str) -> str:
    lines = "".join(
        f'<li data-line="{number}"><code>{escape(line) or " "}</code></li>'
        for number, line in enumerate(text.splitlines(), start=1)
    )
    title = f"Program of {escape(robot)}" if robot else "Program"
    return f'<div class="card program"><h2>{title}</h2><ol data-robot="{escape(robot)}">{lines}</ol></div>'


def _limit_cell(use: LimitUse, joint: int) -> str:
    peak, limit = float(use.peak[joint]), float(use.limit[joint])
    if not limit > 0.0 or np.isnan(peak):
        return f"<td class='none'><span class='value'>{'–' if np.isnan(peak) else f'{peak:.3g}, no limit'}</span></td>"
    ratio = peak / limit
    level = "over" if ratio > 1 else "near" if ratio > 0.9 else "fine"
    return (
        f'<td class="{level}" title="{peak:.4g} of {limit:.4g} {escape(use.unit)}">'
        f'<span class="bar"><i style="width:{min(ratio, 1):.1%}"></i></span>'
        f"<span class='value'>{peak:.3g} / {limit:.3g}</span><b>{ratio:.0%}</b></td>"
    )


def _mark(number: int, part: Detection, photo: PhotoOverlay) -> str:
    colour = escape(photo.groups[part.group])
    title = f"{number}: {part.group}, {part.diameter:.1f} px"
    return (
        f'<g data-frame="{escape(part.frame)}" style="--c:{colour}"><title>{escape(title)}</title>'
        f'<circle cx="{part.u:.2f}" cy="{part.v:.2f}" r="{part.diameter / 2:.2f}"/>'
        f'<text x="{part.u:.2f}" y="{part.v:.2f}">{number}</text></g>'
    )


def _parts_table(photo: PhotoOverlay) -> str:
    rows = "".join(
        f'<tr data-frame="{escape(part.frame)}"><td>{number}</td>'
        f'<td><i style="background:{escape(photo.groups[part.group])}"></i>{escape(part.group)}</td>'
        f"<td>{1e3 * part.size:.1f}</td><td>{1e3 * part.x:.1f}</td><td>{1e3 * part.y:.1f}</td></tr>"
        for number, part in enumerate(photo.detections, start=1)
    )
    return (
        '<table class="parts"><thead><tr><th>#</th><th>class</th><th>diameter mm</th><th>x mm</th><th>y mm</th>'
        f"</tr></thead><tbody>{rows}</tbody></table>"
    )


def _section(name: str, title: str, body: str) -> str:
    return f'<section id="{name}" class="card"><h2>{escape(title)}</h2>{body}</section>'
