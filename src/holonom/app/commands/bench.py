"""`holonom bench`: speed beside the peer libraries."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output, quiet, seed
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is measured."""

    names: tuple[str, ...] = argument("benchmarks to run, all unless given", metavar="NAME", default=())
    output: Path | None = output("the table goes here as JSON too")
    small: bool = option(False, "only show that everything runs")
    seed: int = seed(0, "seed of the random inputs")
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Measure; raises as `run_benchmarks` does."""
    from holonom.app.about.bench import run_benchmarks

    return run_benchmarks(
        options.names, output=options.output, seed=options.seed, small=options.small, quiet=options.quiet
    )


COMMAND = Method("measure speed beside the peer libraries", run, OWN, Options)
