"""`holonom run`: simulate a cell, record, report."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import allow_outside, argument, output, quiet, seed
from holonom.app.console.printable import say_to
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "GOES", "Options", "run"]

GOES = "recording, summary and report go here (runs/ and the name of the cell's folder unless given)"


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is run, and where its records go."""

    cell: Path = argument("cell file (TOML)", metavar="CELL")
    output: Path | None = output(GOES)
    seed: int | None = seed(None, "seed instead of the cell's own")
    quiet: bool = quiet()
    allow_outside: bool = allow_outside()


def run(options: Options) -> Answer:
    """Run a cell; raises as `run_cell` does."""
    from holonom.app.run import run_cell

    folder = options.output or Path("runs") / options.cell.resolve().parent.name
    stream = sys.stderr if options.quiet else sys.stdout  # with --json, which is quiet, stdout holds JSON only
    return run_cell(
        options.cell, folder, seed=options.seed, quiet=options.quiet, allow_outside=options.allow_outside,
        say=lambda text: say_to(stream, text),
    )  # fmt: skip


COMMAND = Method("run a cell: simulate, record, report", run, OWN, Options)
