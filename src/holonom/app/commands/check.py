"""`holonom check`: what is wrong with a cell, a program, a motor or an axis, off-line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import allow_outside, argument, quiet
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is checked."""

    file: Path = argument("cell, motor or axis (.toml) or program (.arps)", metavar="FILE")
    allow_outside: bool = allow_outside()
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Check a file; raises as `check_file` does."""
    from holonom.app.cell.check_file import check_file

    return check_file(options.file, quiet=options.quiet, allow_outside=options.allow_outside)


COMMAND = Method("check a cell, an ARPS program, or the data sheet of a motor or axis, off-line", run, OWN, Options)
