"""Comparing how well several runs kept to one path, part by part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from holonom.app.report.markup import Html, html, joined
from holonom.arrays import Array

__all__ = ["ComparedRun", "Comparison", "Phase", "comparison_html", "phase_errors"]


_COLOURS = ("#d9480f", "#0b7285", "#5f3dc4", "#2b8a3e")
_SIDE = 300.0
LEAST = 1e-3
"""m of a path that is drawn as large as any, so that a run in which nothing moves is drawn, too."""
"""Side of a drawing, in its own units."""


@dataclass(frozen=True, slots=True)
class Phase:
    """A part of a run, from `start` to `end` in s of that run."""

    name: str
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class ComparedRun:
    """One run: `time` (N,) in s, `desired` and `actual` tool points (N, 3) in m, and its phases."""

    name: str
    time: Array
    desired: Array
    actual: Array
    phases: tuple[Phase, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Runs with the same phases in the same order; each is set against the last one."""

    runs: tuple[ComparedRun, ...]
    name: str = "comparison"
    title: str = "Tracking error compared"


def phase_errors(run: ComparedRun, phase: Phase) -> tuple[float, float]:
    """Root mean square and peak of the distance between desired and actual tool point at the same instant, m."""
    desired, actual = _within(run, phase)
    distance = np.linalg.norm(actual - desired, axis=1)
    return float(np.sqrt(np.mean(distance**2))), float(distance.max())


def comparison_html(comparison: Comparison) -> Html:
    """A table of errors with ratios, and drawings of the path with the deviation magnified."""
    drawings = joined(_phase_drawings(comparison, i) for i in range(len(comparison.runs[0].phases)))
    return html(
        '<section id="{}" class="card comparison"><h2>{}</h2><div class="wide">{}</div><div class="drawings">{}</div>'
        '<p class="note">Distance between the desired and the actual tool point at the same instant.</p></section>',
        comparison.name, comparison.title, _table(comparison), drawings,
    )  # fmt: skip


def _table(comparison: Comparison) -> Html:
    runs, last = comparison.runs, comparison.runs[-1]
    head = joined(
        html('<th colspan="2"><i style="background:{}"></i>{}</th>', _COLOURS[i % 4], run.name)
        for i, run in enumerate(runs)
    )
    ratios = joined(html('<th colspan="2">{} : {}</th>', run.name, last.name) for run in runs[:-1])
    units = Html("<th>rms mm</th><th>peak mm</th>" * len(runs) + "<th>rms</th><th>peak</th>" * (len(runs) - 1))
    rows = joined(_table_row(comparison, i) for i in range(len(last.phases)))
    return html(
        '<table class="compare"><thead><tr><th></th>{}{}</tr><tr><th></th>{}</tr></thead><tbody>{}</tbody></table>',
        head, ratios, units, rows,
    )  # fmt: skip


def _table_row(comparison: Comparison, index: int) -> Html:
    errors = [phase_errors(run, run.phases[index]) for run in comparison.runs]
    values = joined(html("<td>{:.3f}</td><td>{:.3f}</td>", 1e3 * rms, 1e3 * peak) for rms, peak in errors)
    ratios = joined(
        html("<td><b>{}</b></td><td><b>{}</b></td>", _ratio(rms, errors[-1][0]), _ratio(peak, errors[-1][1]))
        for rms, peak in errors[:-1]
    )
    return html("<tr><th>{}</th>{}{}</tr>", comparison.runs[-1].phases[index].name, values, ratios)


def _ratio(above: float, below: float) -> str:
    return f"{above / below:.1f}" if below > 0 else "∞"


def _phase_drawings(comparison: Comparison, index: int) -> Html:
    parts = [_within(run, run.phases[index]) for run in comparison.runs]
    desired = np.concatenate([part[0] for part in parts])
    plane = _drawing_plane(desired)
    flat = (desired - desired.mean(axis=0)) @ plane.T
    extent = max(float(np.ptp(flat, axis=0).max()), LEAST)
    worst = max(float(np.linalg.norm((actual - wanted) @ plane.T, axis=1).max()) for wanted, actual in parts)
    gain = _round_down(0.12 * extent / worst) if worst > 0 else 1.0
    centre = (flat.max(axis=0) + flat.min(axis=0)) / 2 + desired.mean(axis=0) @ plane.T
    scale = 0.72 * _SIDE / extent
    return joined(
        _drawing(run.name, run.phases[index].name, gain, _COLOURS[i % 4], _lines(part, plane, centre, scale, gain))
        for i, (run, part) in enumerate(zip(comparison.runs, parts, strict=True))
    )


def _lines(part: tuple[Array, Array], plane: Array, centre: Array, scale: float, gain: float) -> tuple[str, str]:
    """SVG points of the desired path and of the actual one with its deviation magnified."""
    desired, actual = part
    wanted = (desired @ plane.T - centre) * scale
    shown = wanted + gain * scale * (actual - desired) @ plane.T
    return _points(wanted), _points(shown)


def _points(flat: Array) -> str:
    x, y = _SIDE / 2 + flat[:, 0], _SIDE / 2 - flat[:, 1]
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))


def _drawing(run: str, phase: str, gain: float, colour: str, lines: tuple[str, str]) -> Html:
    return html(
        '<figure><svg viewBox="0 0 {side:g} {side:g}" role="img" aria-label="path of {run}">'
        '<polyline class="desired" points="{wanted}"/><polyline points="{shown}" style="stroke:{colour}"/></svg>'
        "<figcaption><b>{phase}</b>, {run}<br>deviation × {gain:g}</figcaption></figure>",
        side=_SIDE, run=run, wanted=lines[0], shown=lines[1], colour=colour, phase=phase, gain=gain,
    )  # fmt: skip


def _drawing_plane(points: Array) -> Array:
    """Right and up (2, 3) in the plane that fits the points best: up is world z, or world y in a level plane."""
    normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][2]
    level = abs(normal[2]) > 0.7
    up = np.array([0.0, 1.0, 0.0]) if level else np.array([0.0, 0.0, 1.0])
    up -= normal * (normal @ up)
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    toward = right[0] if level else right[1]
    return np.array([right if toward >= 0 else -right, up])


def _round_down(value: float) -> float:
    """The next lower of 1, 2, 5, 10, 20, 50, ...; at least 1."""
    decade = 10.0 ** np.floor(np.log10(max(value, 1.0)))
    return float(max(step * decade for step in (1, 2, 5) if step * decade <= max(value, 1.0)))


def _within(run: ComparedRun, phase: Phase) -> tuple[Array, Array]:
    inside = (run.time >= phase.start) & (run.time <= phase.end)
    return run.desired[inside], run.actual[inside]
