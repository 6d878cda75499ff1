"""`holonom calibrate drive`: friction, back EMF and inertia of each wheel's drive from a recorded motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from holonom.app.console.answer import Answer
from holonom.app.console.options import argument, option, output
from holonom.registry import OWN, Method

__all__ = ["COMMAND", "Options", "run"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """A log, and the motor's data sheet where it is known."""

    log: Path = argument("CSV with voltages and angles or speeds of the wheels, or recording of a base", metavar="LOG")
    resistance: float | None = option(None, "of the armature", metavar="OHM", unit="ohm")
    torque_constant: float | None = option(None, "of the motor, with --resistance", metavar="K", unit="N m/A")
    back_emf_constant: float | None = option(None, "the torque constant unless given", metavar="K", unit="V s/rad")
    gear: float = option(1.0, "motor turns per wheel turn", metavar="N")
    output: Path | None = output("drive.json goes here")


def run(options: Options) -> Answer:
    """Identify; raises as `calibrate_drive` does."""
    from holonom.app.calibrate.drive import calibrate_drive
    from holonom.errors import CalibrationError
    from holonom.mobile.drive.identification import MotorConstants

    motor = None
    if options.resistance is not None and options.torque_constant is not None:
        motor = MotorConstants(options.resistance, options.torque_constant, options.back_emf_constant, options.gear)
    elif any(value is not None for value in (options.resistance, options.torque_constant, options.back_emf_constant)):
        raise CalibrationError(
            "--resistance and --torque-constant are needed together, for friction and inertia in N m"
        )
    return calibrate_drive(options.log, motor=motor, output=options.output)


COMMAND = Method("friction, back EMF and inertia of each wheel's drive, from a recorded motion", run, OWN, Options)
