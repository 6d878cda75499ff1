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

    file: Path = argument("TOML with a table [process], or [motor] and the tables of an axis", metavar="FILE")
    rule: str | None = option(
        None, "of holonom methods rules, or all; by the process unless given",
        choices="holonom.app.drives.tuning.process:RULE_NAMES",
    )  # fmt: skip
    output: Path | None = output("report.html, tuning.json, step.csv go here")


def run(options: Options) -> Answer:
    """Tune; raises as `tune_file` does."""
    from holonom.app.drives.tuning.file import tune_file

    return tune_file(options.file, rule=options.rule, output=options.output)


COMMAND = Method(
    "gains of a servo axis from its sheets, or of a regulator for a process, with what they promise", run, OWN, Options
)
