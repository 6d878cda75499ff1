"""`holonom select`: motor and gear for a load cycle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, quiet
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """A cycle, or an arm's motion."""

    file: Path = argument("load cycle or cell (.toml), or recording (.mcap)", metavar="FILE")
    joint: str | None = option(None, "name or number of a joint, or all; of a recording or cell", metavar="N")
    arm: str | None = option(None, "preset or URDF file of the recorded arm, for torques by its model", metavar="ARM")
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Select; raises as `select`."""
    from holonom.app.drives.select import select

    return select(options.file, joint=options.joint, arm=options.arm, quiet=options.quiet)


COMMAND = Method(
    "motor and gear for a load cycle or an arm's own motion, ranked, rejections explained", run, OWN, Options
)
