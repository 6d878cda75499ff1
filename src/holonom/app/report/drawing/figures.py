"""Figures of the report that need no script: maps seen from above, polar plots, tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from holonom.app.report.drawing.polar import Polar, polar_svg
from holonom.app.report.drawing.topview import TopView, topview_svg

__all__ = ["Figures", "Table", "figures_html"]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under a head, all of one length."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, slots=True)
class Figures:
    """One section: a title, a note below it, and what is shown side by side; `name` is its place in the page.

    `notes` are sentences of their own, a line each.
    """

    name: str
    title: str
    figures: Sequence[Polar | TopView | Table]
    note: str = ""
    notes: Sequence[str] = ()


def figures_html(section: Figures) -> str:
    """The section; tables take the whole width."""
    body = "".join(_figure(figure) for figure in section.figures)
    note = f'<p class="note">{escape(section.note)}</p>' if section.note else ""
    return (
        f'<section id="{escape(section.name)}" class="card"><h2>{escape(section.title)}</h2>{note}'
        f'<div class="figures">{body}</div>{_listed(section.notes)}</section>'
    )


def _listed(notes: Sequence[str]) -> str:
    return f'<ul class="notes">{"".join(f"<li>{escape(note)}</li>" for note in notes)}</ul>' if notes else ""


def _figure(figure: Polar | TopView | Table) -> str:
    match figure:
        case Polar():
            return _captioned(
                "polar", polar_svg(figure), figure.title, _legend([(c.name, c.colour) for c in figure.lines])
            )
        case TopView():
            legend = _legend([(line.name, line.colour) for line in figure.lines if line.name])
            return _captioned("topview", topview_svg(figure), figure.title, legend)
        case Table():
            return _table(figure)


def _captioned(kind: str, svg: str, title: str, legend: str) -> str:
    return f'<figure class="{kind}"><figcaption><b>{escape(title)}</b></figcaption>{svg}{legend}</figure>'


def _legend(entries: Sequence[tuple[str, str]]) -> str:
    items = "".join(f'<li><i style="background:{escape(colour)}"></i>{escape(name)}</li>' for name, colour in entries)
    return f'<ul class="legend">{items}</ul>'


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(text)}</th>" for text in table.head)
    rows = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in table.rows)
    return f'<table class="plain"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
