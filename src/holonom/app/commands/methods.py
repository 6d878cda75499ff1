"""`holonom methods`: what there is to choose from, with parameters, ranges and sources."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """Which kind, and as what."""

    kind: str | None = argument(
        "kind of method; all kinds unless given",
        metavar="KIND",
        default=None,
        choices="holonom.app.about.tables:TABLES",
    )
    markdown: bool = option(False, "all kinds as a page: holonom methods --markdown > docs/methods.md")


def run(options: Options) -> Answer:
    """List the kinds, or the methods of one."""
    from holonom.app.about import methods

    if options.markdown:
        return methods.page()
    return methods.kinds() if options.kind is None else methods.of_kind(options.kind)


COMMAND = Method("list what there is of a kind: controllers, sensors, profiles, ...", run, OWN, Options)
