"""`holonom report`: the report of a recording."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, output, quiet
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """Which recording, and where its report goes."""

    recording: Path = argument("recording of a run (MCAP), also one that was cut off", metavar="RECORDING")
    output: Path | None = output("report.html goes here (beside the recording unless given)")
    quiet: bool = quiet()


def run(options: Options) -> Answer:
    """Write the report; raises as `report_recording` does."""
    from holonom.app.report.reporting import report_recording

    return report_recording(options.recording, options.output or options.recording.resolve().parent)


COMMAND = Method("report of a recording, also an old one, or of a run that was killed", run, OWN, Options)
