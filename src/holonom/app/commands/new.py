"""`holonom new`: a first cell of one's own, with comments and a program, that runs at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, quiet
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What robot, and where it is written."""

    kind: str = argument("arm, base, or agv: an arm on a base", metavar="KIND", choices="holonom.app.start.new:KINDS")
    folder: Path = argument("folder to write to; one that holds something is refused", metavar="DIR")
    model: str | None = option(
        None,
        "of arm and agv a preset (holonom methods presets) or a .urdf or .xacro file, of a base an arrangement "
        "(holonom methods arrangements)",
        metavar="PRESET|FILE",
    )
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Write a cell; raises as `new_cell` does."""
    from holonom.app.start.new import new_cell

    return new_cell(options.kind, options.folder, model=options.model, quiet=options.quiet)


COMMAND = Method("write a commented cell and a program to begin with", run, OWN, Options)
