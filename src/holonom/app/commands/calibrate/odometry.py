"""`holonom calibrate odometry`: the wheels of a mobile base from logs of them and the truth."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]

_LIMITS = ("M", "DEG", "M_END", "DEG_END")


@dataclass(frozen=True, kw_only=True)
class Options:
    """Logs, and how they are used."""

    logs: tuple[Path, ...] = argument("OptiOdom folder, or TOML beside its CSV or MCAP", metavar="LOG|FOLDER")
    drive: str | None = option(None, "that of the logs unless given: a drive, or an arrangement", metavar="NAME")
    method: str = option("least-squares", "how", choices="holonom.app.calibrate.odometry:METHODS")
    parameters: str | None = option(
        None, "of least squares; extended where the runs are better for it", choices="holonom.mobile.calibration:SETS"
    )
    form: str | None = option(None, "of UMBmark, x unless given", choices="holonom.mobile.calibration.umbmark:FORMS")
    rule: str = option("midpoint", "of integration", choices="holonom.mobile.odometry:RULES")
    held_out: bool = option(False, "also errors of each run by the others' calibration")
    runs_alone: bool = option(False, "nominal lengths do not count as measured beside the runs")
    limits: tuple[float, float, float, float] | None = option(
        None, "largest errors allowed, inf for none", metavar=_LIMITS, most=float("inf")
    )
    classical_limits: bool = option(False, "largest errors no worse than a classical calibration's")
    allow_gaps: bool = option(False, "gaps in a log are a note, not an error")
    mcap: bool = option(False, "with -o, the runs too, as MCAP with truth and odometry")
    output: Path | None = output("odometry.json and a picture of the paths go here")


def run(options: Options) -> Answer:
    """Calibrate; raises as `calibrate_odometry` does."""
    from holonom.app.calibrate.odometry import calibrate_odometry

    return calibrate_odometry(
        options.logs,
        drive=options.drive,
        method=options.method,
        parameters=options.parameters,
        form=options.form,
        rule=options.rule,
        held_out=options.held_out,
        data_sheet=not options.runs_alone,
        limits=options.limits,
        classical_limits=options.classical_limits,
        allow_gaps=options.allow_gaps,
        mcap=options.mcap,
        output=options.output,
    )


COMMAND = Method("wheels of a mobile base, from logs of them and the truth", run, OWN, Options)
