"""Figures of the report that need no script: maps seen from above, polar plots, tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from holonom.app.report.drawing.polar import Polar, polar_svg
from holonom.app.report.drawing.topview import TopView, legend_of, topview_svg
from holonom.app.report.markup import Html, colour, html, joined

__all__ = ["Figures", "Table", "figures_html"]

MANY = 12
"""Rows from which on a table scrolls."""


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


def figures_html(section: Figures) -> Html:
    """The section; tables take the whole width."""
    note = html('<p class="note">{}</p>', section.note) if section.note else Html()
    return html(
        '<section id="{}" class="card"><h2>{}</h2>{}<div class="figures">{}</div>{}</section>',
        section.name, section.title, note, joined(map(_figure, section.figures)), _listed(section.notes),
    )  # fmt: skip


def _listed(notes: Sequence[str]) -> Html:
    if not notes:
        return Html()
    return html('<ul class="notes">{}</ul>', joined(html("<li>{}</li>", note) for note in notes))


def _figure(figure: Polar | TopView | Table) -> Html:
    match figure:
        case Polar():
            legend = _legend([(line.name, line.colour) for line in figure.lines])
            return _captioned("polar", polar_svg(figure), figure.title, legend)
        case TopView():
            kind = "topview" if figure.lines else "topview near"
            return _captioned(kind, topview_svg(figure), figure.title, _legend(legend_of(figure)))
        case Table():
            return _table(figure)


def _captioned(kind: str, svg: Html, title: str, legend: Html) -> Html:
    return html(
        '<figure class="{}"><figcaption><b>{}</b></figcaption><div class="wide">{}</div>{}</figure>',
        kind, title, svg, legend,
    )  # fmt: skip


def _legend(entries: Sequence[tuple[str, str]]) -> Html:
    items = joined(html('<li><i style="background:{}"></i>{}</li>', colour(own), name) for name, own in entries)
    return html('<ul class="legend">{}</ul>', items)


def _table(table: Table) -> Html:
    """A table; a long one scrolls under its head."""
    head = joined(html("<th>{}</th>", text) for text in table.head)
    rows = joined(html("<tr>{}</tr>", joined(html("<td>{}</td>", text) for text in row)) for row in table.rows)
    return html(
        '<div class="plain {}"><table><thead><tr>{}</tr></thead><tbody>{}</tbody></table></div>',
        "scroll" if len(table.rows) > MANY else "wide", head, rows,
    )  # fmt: skip
