"""The page as a whole."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from importlib.resources import files
from pathlib import Path

from holonom.app.recording import Recording
from holonom.app.report.drawing.curves import Curve, joint_curves
from holonom.app.report.drawing.embed import Blob, add_curves, add_frames, replay_rate
from holonom.app.report.drawing.figures import Figures
from holonom.app.report.drawing.scene import Scene
from holonom.app.report.drawing.scene_text import scene_json
from holonom.app.report.findings.comparison import Comparison
from holonom.app.report.parts import CurveGroup, EventLog, LimitTable, Part, curves_of, part_html
from holonom.app.report.sections import LimitUse, Outcome, PhotoOverlay, facts_html, programs_html, robot_of
from holonom.errors import OutputError
from holonom.signals import Event

__all__ = ["Head", "page_html", "write_report"]

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
) -> str:
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
    data = {
        "end": recording.end(),
        "curves": add_curves(blob, curves_of(parts)),
        "events": [[e.time, e.line, e.level, e.text, robot_of(e, programs)] for e in shown],
        "scene": {**scene_json(scene), "rate": rate, **({"shapes": []} if missing else {})},
        "index": blob.index,
    }
    values = {
        "title": escape(head.title),
        "subtitle": escape(head.subtitle),
        "outcome": f'<p class="outcome {"ok" if head.outcome.ok else "bad"}">{escape(head.outcome.text)}</p>',
        "facts": facts_html(head.facts),
        "program": programs_html(programs),
        "tool": escape(scene.tool.replace("_", " ")),
        "sections": "\n".join(map(part_html, parts)),
        "licences": escape(_asset("VERSIONS") + "\n" + _asset("LICENSE.three") + "\n" + _asset("LICENSE.uplot")),
        "style": _asset("uplot.min.css") + _asset("report.css"),
        "vendor": _inline(_asset("vendor.min.js")),
        "script": _inline("\n".join(_asset(f"{part}.js") for part in ("stage", "curves", "replay"))),
        "data": _inline(json.dumps(data, separators=(",", ":"))),
        "blob": blob.text(),
    }
    return _PLACE.sub(lambda place: values[place[1]], _asset("report.html"))


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


def _inline(text: str) -> str:
    """Script text that no `</script` within it can end."""
    return text.replace("</script", "<\\/script")
