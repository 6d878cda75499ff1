"""Blocks of the report that need no script: how it ended, facts, photograph, programs."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass

from holonom.app.report.markup import Html, colour, html, joined
from holonom.arrays import Array

__all__ = [
    "Detection",
    "LimitUse",
    "Outcome",
    "PhotoOverlay",
    "facts_html",
    "outcome_html",
    "photo_html",
    "programs_html",
]

TONES = ("ok", "held", "bad", "unsaid")
"""How a badge looks: green, amber, red, grey."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """How the run ended: whether well, and one line that says it.

    `tone` is one of `TONES`: "held" of a run that somebody paused or stopped, "unsaid" of a recording that does not say
    how it ended; unless given it follows from `ok`.
    """

    ok: bool
    text: str
    tone: str = ""


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


def outcome_html(outcome: Outcome) -> Html:
    """The badge."""
    tone = outcome.tone or ("ok" if outcome.ok else "bad")
    return html('<p class="outcome {}">{}</p>', tone, outcome.text)


def facts_html(facts: Mapping[str, str]) -> Html:
    """The run in a few numbers: label and value."""
    items = joined(html("<div><dt>{}</dt><dd>{}</dd></div>", label, value) for label, value in facts.items())
    return html('<dl class="facts">{}</dl>', items) if facts else Html()


def photo_html(photo: PhotoOverlay) -> Html:
    """The photograph with a numbered circle on every part found."""
    counts = {group: sum(part.group == group for part in photo.detections) for group in photo.groups}
    legend = joined(
        html('<li><i style="background:{}"></i>{} <b>{}</b></li>', colour(own), group, counts[group])
        for group, own in photo.groups.items()
    )
    return html(
        '<section id="photograph" class="card"><h2>What the camera saw</h2>'
        '<figure class="photo" style="aspect-ratio:{width:d}/{height:d}">'
        '<img id="photo" alt="photograph of the table" src="data:image/png;base64,{image}">'
        '<svg viewBox="0 0 {width:d} {height:d}" role="img" aria-label="parts found">{marks}</svg></figure>'
        '<div class="found"><div class="scroll">{table}</div></div><ul class="legend">{legend}</ul>{caption}</section>',
        width=photo.width,
        height=photo.height,
        image=base64.b64encode(photo.png).decode(),
        marks=joined(_mark(i, part, photo) for i, part in enumerate(photo.detections, start=1)),
        table=_parts_table(photo),
        legend=legend,
        caption=html('<p class="note">{}</p>', photo.caption) if photo.caption else Html(),
    )


def programs_html(programs: Mapping[str, str]) -> Html:
    """The programs by their robots, line by line; the script marks the lines that run."""
    return joined(_program(robot, text) for robot, text in programs.items() if text)


def _program(robot: str, text: str) -> Html:
    lines = joined(
        html('<li data-line="{}"><code>{}</code></li>', number, line or " ")
        for number, line in enumerate(text.removesuffix("\n").split("\n"), start=1)
    )
    title = f"Program of {robot}" if robot else "Program"
    return html('<div class="card program"><h2>{}</h2><ol data-robot="{}">{}</ol></div>', title, robot, lines)


def _mark(number: int, part: Detection, photo: PhotoOverlay) -> Html:
    return html(
        '<g data-frame="{}" style="--c:{}"><title>{}: {}, {:.1f} px</title><circle cx="{:.2f}" cy="{:.2f}" r="{:.2f}"/>'
        '<text x="{:.2f}" y="{:.2f}">{}</text></g>',
        part.frame, colour(photo.groups[part.group]), number, part.group, part.diameter, part.u, part.v,
        part.diameter / 2, part.u, part.v, number,
    )  # fmt: skip


def _parts_table(photo: PhotoOverlay) -> Html:
    rows = joined(
        html(
            '<tr data-frame="{}"><td>{}</td><td><i style="background:{}"></i>{}</td>'
            "<td>{:.1f}</td><td>{:.1f}</td><td>{:.1f}</td></tr>",
            part.frame, number, colour(photo.groups[part.group]), part.group, 1e3 * part.size, 1e3 * part.x,
            1e3 * part.y,
        )
        for number, part in enumerate(photo.detections, start=1)
    )  # fmt: skip
    return html(
        '<table class="parts"><thead><tr><th>#</th><th>class</th><th>diameter mm</th><th>x mm</th><th>y mm</th></tr>'
        "</thead><tbody>{}</tbody></table>",
        rows,
    )
