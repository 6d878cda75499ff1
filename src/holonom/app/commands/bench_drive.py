"""`holonom bench drive`: laws of paths on every arrangement of wheels, and how errors of odometry grow."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output, quiet, seed
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is driven."""

    arrangements: tuple[str, ...] = argument("arrangements of wheels, all unless given", metavar="NAME", default=())
    laws: tuple[str, ...] = option((), "laws of a path, all unless given", metavar="LAW")
    markdown: bool = option(False, "as a page: holonom bench drive --markdown > docs/drive_bench.md")
    output: Path | None = output("drive_bench.json goes here")
    small: bool = option(False, "only show that everything runs")
    seed: int = seed(0, "seed of noise and simulated runs")
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Drive; raises as `bench_drive` does."""
    from holonom.app.about.drive_bench.tables import bench_drive

    return bench_drive(
        options.arrangements,
        laws=options.laws,
        seed=options.seed,
        small=options.small,
        markdown=options.markdown,
        output=options.output,
        quiet=options.quiet,
    )


COMMAND = Method("laws of paths on every arrangement of wheels, how odometry's errors grow", run, OWN, Options)
