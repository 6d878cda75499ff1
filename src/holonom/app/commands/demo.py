"""`holonom demo`: run an example that comes with Holonom."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.commands import run as run_command
from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, output, quiet, seed
from holonom.app.start.demo import DEFAULT, example
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """Which example, and where its records go."""

    name: str = argument(
        "example, such as straight_lines; a name that is none lists them", metavar="NAME", default=DEFAULT
    )
    output: Path | None = output(run_command.GOES)
    seed: int | None = seed(None, "seed instead of the cell's own")
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Run an example as `holonom run` runs a cell; `UnknownName` lists the examples."""
    cell = example(options.name)
    return run_command.run(
        run_command.Options(cell=cell, output=options.output, seed=options.seed, quiet=options.quiet)
    )


COMMAND = Method("run an example: a robot sorts coins, unless another is named", run, OWN, Options)
