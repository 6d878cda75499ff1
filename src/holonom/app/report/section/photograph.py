"""Section: what the camera saw."""

from __future__ import annotations

from holonom.app.report.section_table import Section
from holonom.app.report.source import Source
from holonom.registry import OWN, Method

__all__ = ["SECTION"]


def _applies(source: Source) -> bool:
    return source.photograph is not None


SECTION = Method(
    "what the camera saw", lambda _: Section(_applies, lambda s: [s.photograph] if s.photograph else []), OWN
)
