"""`holonom calibrate process`: a process from a recorded step, or from a relay experiment."""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """A record, and what was done in it."""

    log: Path = argument("CSV with columns time (s; or t), u (or input) and y (or output)", metavar="LOG")
    experiment: str = option(MISSING, "what was done", choices="holonom.app.calibrate.process:EXPERIMENTS")
    kind: str | None = option(
        None, "of model, the best one unless given", choices="holonom.control.processes.identify:MODELS"
    )
    hysteresis: float = option(0.0, "of the relay: it switches where the error crosses +-H", metavar="H", least=0.0)
    output: Path | None = output("process.toml, which holonom tune takes, and process.json go here")


def run(options: Options) -> Answer:
    """Identify; raises as `calibrate_process` does."""
    from holonom.app.calibrate.process import calibrate_process

    return calibrate_process(
        options.log, options.experiment, kind=options.kind, hysteresis=options.hysteresis, output=options.output
    )


COMMAND = Method("lags, dead time and gain of a process, from a recorded step or relay experiment", run, OWN, Options)
