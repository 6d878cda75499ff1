"""The page as a whole."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from holonom.app.recording import Recording
from holonom.app.report.comparison import Comparison
from holonom.app.report.curves import Curve, joint_curves
from holonom.app.report.embed import Blob, add_curves, add_frames, scene_json
from holonom.app.report.figures import Figures
from holonom.app.report.scene import Scene
from holonom.app.report.section_table import Content, sections_html
from holonom.app.report.sections import LimitUse, Outcome, PhotoOverlay, facts_html, program_html
from holonom.errors import OutputError

__all__ = ["write_report"]

_PLACE = re.compile(r"\{\{(\w+)\}\}")


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
    """Write the report of a run as one HTML file that needs no network.

    Parameters
    ----------
    path
        The file to write.
    recording
        What happened; it may end early, or be empty.
    scene
        What the replay draws. Its frames must be in the recording, unless that holds no frame at all.
    title, subtitle, outcome, facts
        The head of the page; `facts` are a few labels with their values, units included.
    curves
        What is drawn over time; those of the recorded joints unless given.
    figures, limits, photograph, comparison
        Sections, left out where nothing is given.
    program
        Text of the program; the replay marks the line of the last event.

    Raises
    ------
    UnknownName
        The scene names a frame that the recording does not have.
    OutputError
        The file cannot be written.
    """
    blob = Blob()
    missing = add_frames(blob, recording, scene)
    shown = joint_curves(recording) if curves is None else curves
    data = {
        "end": recording.end(),
        "curves": add_curves(blob, shown),
        "events": [[event.time, event.line, event.level, event.text] for event in recording.events],
        "scene": {**scene_json(scene), "shapes": []} if missing else scene_json(scene),
        "index": blob.index,
    }
    values = {
        "title": escape(title),
        "subtitle": escape(subtitle),
        "outcome": f'<p class="outcome {"ok" if outcome.ok else "bad"}">{escape(outcome.text)}</p>',
        "facts": facts_html(facts or {}),
        "program": program_html(program),
        "tool": escape(scene.tool.replace("_", " ")),
        "sections": sections_html(Content(recording, shown, figures, limits, photograph, comparison)),
        "licences": escape(_asset("VERSIONS") + "\n" + _asset("LICENSE.three") + "\n" + _asset("LICENSE.uplot")),
        "style": _asset("uplot.min.css") + _asset("report.css"),
        "vendor": _inline(_asset("vendor.min.js")),
        "script": _inline("\n".join(_asset(f"{part}.js") for part in ("stage", "curves", "replay"))),
        "data": _inline(json.dumps(data, separators=(",", ":"))),
        "blob": blob.text(),
    }
    page = _PLACE.sub(lambda place: values[place[1]], _asset("report.html"))
    _write(Path(path), page)


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
