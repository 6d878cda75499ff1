"""Section: what of the recording could not be read."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.app.recording import Missing
from holonom.app.report.drawing.figures import Figures, Table
from holonom.app.report.section_table import Section
from holonom.app.report.source import Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]

HEAD = ("from", "to", "what could not be read")
ROWS = 100
NOTE = "The file is damaged or was cut off. What is shown elsewhere is made from the rest; nothing is filled in."


def _applies(source: Source) -> bool:
    return bool(source.lost)


def _parts(source: Source) -> Sequence[Figures]:
    lost = source.whole.missing
    more = f" The first {ROWS} of {len(lost)} are shown." if len(lost) > ROWS else ""
    figures = [Table(HEAD, [*map(_row, lost[:ROWS])])] if lost else []
    return [Figures("missing", "Missing from the recording", figures, NOTE + more, source.unread)]


def _row(lost: Missing) -> tuple[str, ...]:
    since = "the beginning" if lost.since is None else f"{lost.since:.3f} s"
    until = "the end" if lost.until_then is None else f"{lost.until_then:.3f} s"
    return since, until, ", ".join(lost.reasons)


SECTION = Method("what of a damaged recording could not be read", lambda _: Section(_applies, _parts), OWN)
