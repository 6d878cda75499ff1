"""The page as a whole."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from holonom.app.recording import Recording
from holonom.app.report.drawing.curves import Curve, joint_curves
from holonom.app.report.drawing.embed import Blob, add_curves, add_frames, replay_rate
from holonom.app.report.drawing.event_log import event_rows, robot_of
from holonom.app.report.drawing.figures import Figures
from holonom.app.report.drawing.scene import Scene
from holonom.app.report.drawing.scene_text import scene_json
from holonom.app.report.findings.comparison import Comparison
from holonom.app.report.markup import Html, html, joined, policy, script_json
from holonom.app.report.parts import CurveGroup, EventLog, LimitTable, Part, curves_of, drawn
from holonom.app.report.sections import LimitUse, Outcome, PhotoOverlay, facts_html, outcome_html, programs_html
from holonom.errors import OutputError
from holonom.signals import Event

__all__ = ["Head", "page_html", "unmade_html", "write_report"]

_PLACE = re.compile(r"\{\{(\w+)\}\}")


@dataclass(frozen=True, slots=True)
class Head:
    """The head of a page; `facts` are a few labels with their values, units included."""

    title: str
    outcome: Outcome
    subtitle: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)


def page_html(
    head: Head,
    recording: Recording,
    scene: Scene,
    parts: Sequence[Part],
    *,
    programs: Mapping[str, str] | None = None,
    events: Sequence[Event] | None = None,
) -> Html:
    """Return a report: head, replay, programs, and parts below.

    Parameters
    ----------
    head
        Title, outcome, facts.
    recording
        Frames of the replay, by their full names, and events; it may end early, or be empty.
    scene
        What the replay draws. Its frames must be in the recording, unless that holds no frame at all.
    parts
        What stands below, in this order.
    programs
        Texts of programs by the robots of the cell, "" for one that has none; the replay marks the line of the last
        event of each, and says whose an event is.
    events
        Those that the replay shows; all of the recording unless given.

    Raises
    ------
    UnknownName
        The scene names a frame that the recording does not have.
    """
    blob, rate = Blob(), replay_rate(recording, scene)
    programs = programs or {}
    missing = add_frames(blob, recording, scene, rate)
    shown = recording.events if events is None else events
    _, rows = event_rows(shown, programs)
    blocks = [drawn(part) for part in parts]
    data = {
        "end": recording.end(),
        "curves": add_curves(blob, curves_of([part for part, _ in blocks])),
        "events": [
            [e.time, e.line, e.level, e.text, robot_of(e, programs), row] for e, row in zip(shown, rows, strict=True)
        ],
        "scene": {**scene_json(scene), "rate": rate, **({"shapes": []} if missing else {})},
        "index": blob.index,
    }
    vendor, script = (_script(*names) for names in (("vendor.min",), ("stage", "flat", "curves", "replay")))
    values = {
        "policy": policy([vendor, script]),
        "title": html("{}", head.title),
        "subtitle": html("{}", head.subtitle),
        "outcome": outcome_html(head.outcome),
        "facts": facts_html(head.facts),
        "program": programs_html(programs),
        "tool": html("{}", scene.tool.replace("_", " ")),
        "sections": joined((block for _, block in blocks), "\n"),
        "licences": html("{}\n{}\n{}", *(_asset(name) for name in ("VERSIONS", "LICENSE.three", "LICENSE.uplot"))),
        "style": Html(_asset("uplot.min.css") + _asset("report.css")),
        "vendor": vendor,
        "script": script,
        "data": script_json(data),
        "blob": html("{}", blob.text()),
    }
    return Html(_PLACE.sub(lambda place: values[place[1]], _asset("report.html")))


def unmade_html(title: str, outcome: Outcome, why: str) -> Html:
    """Return what stands in a report's place that could not be made."""
    return html(
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" '
        "content=\"default-src 'none'\"><title>{0} · Holonom</title></head><body><h1>{0}</h1>{1}"
        "<p>The report could not be made ({2}). The recording beside it holds all that happened.</p></body></html>",
        title, outcome_html(outcome), why,
    )  # fmt: skip


def write_report(
    path: str | Path,
    recording: Recording,
    scene: Scene,
    *,
    title: str,
    outcome: Outcome,
    subtitle: str = "",
    facts: Mapping[str, str] | None = None,
    curves: Sequence[Curve] | None = None,
    figures: Sequence[Figures] = (),
    limits: Sequence[LimitUse] = (),
    photograph: PhotoOverlay | None = None,
    comparison: Comparison | None = None,
    program: str = "",
) -> None:
    """Write a report of a recording with sections that are handed in; see `page_html`.

    Parameters
    ----------
    path
        The file to write.
    recording, scene
        Of one robot that is alone, and what the replay draws.
    title, subtitle, outcome, facts
        The head of the page.
    curves
        What is drawn over time; those of the recorded joints unless given.
    figures, limits, photograph, comparison
        Sections, left out where nothing is given.
    program
        Text of the program.

    Raises
    ------
    UnknownName
        The scene names a frame that the recording does not have.
    OutputError
        The file cannot be written.
    """
    parts: list[Part] = [*([comparison] if comparison else []), *figures]
    parts.append(CurveGroup(joint_curves(recording) if curves is None else curves))
    parts += [*([photograph] if photograph else []), LimitTable(recording.joint_names, limits)]
    parts.append(EventLog(recording.events))
    head = Head(title, outcome, subtitle, facts or {})
    _write(Path(path), page_html(head, recording, scene, parts, programs={"": program}))


def _write(path: Path, page: str) -> None:
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"cannot write the report {path}: {error.strerror}; give a folder that can be written"
        ) from error


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")


def _script(*names: str) -> Html:
    """Our own scripts as one, as they stand in the page and are hashed: nothing in them ends a script."""
    text = "\n".join(_asset(f"{name}.js") for name in names)
    assert "</script" not in text
    assert "<!--" not in text
    return Html(text)
