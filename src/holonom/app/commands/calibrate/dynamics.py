"""`holonom calibrate dynamics`: masses, inertias and friction of an arm from a recorded motion."""

from __future__ import annotations

from dataclasses import MISSING, dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """A recording, the arm that it is of, and how it is filtered."""

    recording: Path = argument("recording of a run (MCAP)", metavar="RECORDING")
    arm: str = option(MISSING, "preset or URDF file of the arm", metavar="NAME|URDF")
    cutoff: float = option(10.0, "of the filter, Hz", metavar="HZ", unit="Hz")
    no_friction: bool = option(False, "leave the friction as the arm states it")
    output: Path | None = output("dynamics.json goes here")


def run(options: Options) -> Answer:
    """Calibrate; raises as `calibrate_dynamics` does."""
    from holonom.app.calibrate.dynamics import calibrate_dynamics

    friction = not options.no_friction
    return calibrate_dynamics(
        options.recording, options.arm, cutoff=options.cutoff, friction=friction, output=options.output
    )


COMMAND = Method("masses, inertias and friction of an arm, from a recorded motion", run, OWN, Options)
