"""Peaks against limits as tables of bars: of one robot, or of several in groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from holonom.app.report.markup import Html, html, joined
from holonom.app.report.sections import LimitUse

__all__ = ["LimitGroups", "LimitTable", "limit_groups_html", "limits_html"]


@dataclass(frozen=True, slots=True)
class LimitTable:
    """Peaks of quantities against their limits, for joints or wheels by their names."""

    names: Sequence[str]
    uses: Sequence[LimitUse]
    name: str = "limits"
    title: str = "Limits touched"
    note: str = "Largest value of the run against its limit, at any 0.1 ms step: briefer than curves show."


@dataclass(frozen=True, slots=True)
class LimitGroups:
    """Tables of several robots under one head, by the robots' names; the first is open."""

    tables: Sequence[tuple[str, LimitTable]]
    name: str = "limits"
    title: str = "Limits touched"


def limits_html(table: LimitTable) -> Html:
    """A section: joints down and quantities across, each cell a bar from nothing to its limit."""
    if not table.uses:
        return Html()
    return html(
        '<section id="{}" class="card"><h2>{}</h2>{}</section>', table.name, table.title, _table(table)
    )  # fmt: skip


def limit_groups_html(groups: LimitGroups) -> Html:
    """A section with a table for each robot."""
    body = joined(
        html(
            '<details class="group" id="{}"{}><summary>{} <small>{} rows</small></summary>{}</details>',
            table.name, Html(" open" if k == 0 else ""), robot, len(table.names), _table(table),
        )
        for k, (robot, table) in enumerate(groups.tables)
    )  # fmt: skip
    return html('<section id="{}" class="card"><h2>{}</h2>{}</section>', groups.name, groups.title, body)


def _table(table: LimitTable) -> Html:
    head = joined(html("<th>{} <small>{}</small></th>", use.quantity, use.unit) for use in table.uses)
    rows = joined(
        html("<tr><th>{}</th>{}</tr>", joint, joined(_cell(use, i) for use in table.uses))
        for i, joint in enumerate(table.names)
    )
    return html(
        '<div class="scroll tall"><table class="limits"><thead><tr><th></th>{}</tr></thead><tbody>{}</tbody></table>'
        '</div><p class="note">{}</p>',
        head, rows, table.note,
    )  # fmt: skip


def _cell(use: LimitUse, joint: int) -> Html:
    peak, limit = float(use.peak[joint]), float(use.limit[joint])
    if not limit > 0.0 or np.isnan(peak):
        text = "–" if np.isnan(peak) else f"{peak:.3g}, no limit"
        return html('<td class="none"><span class="value">{}</span></td>', text)
    ratio = peak / limit
    level = "over" if ratio > 1 else "near" if ratio > 0.9 else "fine"
    return html(
        '<td class="{}" title="{:.4g} of {:.4g} {}"><span class="bar"><i style="width:{:.1%}"></i></span>'
        '<span class="value">{:.3g} / {:.3g}</span><b>{:.0%}</b></td>',
        level, peak, limit, use.unit, min(ratio, 1.0), peak, limit, ratio,
    )  # fmt: skip
