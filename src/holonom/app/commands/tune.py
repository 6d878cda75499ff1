"""`holonom tune`: gains of a regulator for what a file describes, and what they promise."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What is tuned, and how."""

    file: Path = argument("TOML with a table [process], and [wanted]", metavar="FILE")
    rule: str | None = option(
        None, "of holonom methods rules, or all; by the process unless given",
        choices="holonom.app.tuning.process:RULE_NAMES",
    )  # fmt: skip
    output: Path | None = output("tuning.json, step.csv and bode.csv go here")


def run(options: Options) -> Answer:
    """Tune; raises as `tune_file` does."""
    from holonom.app.tuning.file import tune_file

    return tune_file(options.file, rule=options.rule, output=options.output)


COMMAND = Method(
    "gains of a regulator for a process, by a rule or all of them, with what they promise", run, OWN, Options
)
