"""What a log of odometry holds once it is read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from holonom.errors import CalibrationError, InputError
from holonom.mobile import WheelBase
from holonom.mobile.calibration import DRIVES, Parameters, Run, known_parameters, wheels_of
from holonom.mobile.methods import ARRANGEMENTS

__all__ = ["Columns", "OdometryLog", "Subject", "subject_of"]


class Columns(NamedTuple):
    """Names of columns: of wheels, of steering, and of the joints that steer, less the ending that MCAP files have."""

    wheels: tuple[str, ...]
    steering: tuple[str, ...]
    joints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Subject:
    """What was driven: a drive that is calibrated by name, or an arrangement of wheels.

    Attributes
    ----------
    drive : a key of `DRIVES` or of `ARRANGEMENTS`.
    geometry : numbers of a drive, or arguments of an arrangement.
    base : the arrangement's base; None for a drive.
    """

    drive: str
    geometry: Mapping[str, Any]
    base: WheelBase | None = None

    def parameters(self, set_name: str = "physical") -> Parameters:
        """What is calibrated of it."""
        if self.base is not None:
            return known_parameters(self.base, None, set_name)
        return known_parameters(self.drive, self.geometry, set_name)

    @property
    def columns(self) -> Columns:
        """Names of a log's columns."""
        if self.base is None:
            wheels, joints = wheels_of(self.drive)
            return Columns(wheels, ("steering",) * len(joints), joints)
        wheels, joints = (
            tuple(name.replace(" ", "_") for name in names) for names in (self.base.driven, self.base.steered)
        )
        alone = ("steering",) if len(joints) == 1 else tuple(f"{name}_steering" for name in joints)
        return Columns(wheels, alone, joints)


def subject_of(drive: str, geometry: Mapping[str, Any]) -> Subject:
    """Return what was driven, by its name: with a `wheel_radius` an arrangement, otherwise a drive of `DRIVES`.

    Raises
    ------
    CalibrationError
        Numbers that are not those of the drive, or arguments that the arrangement refuses.
    UnknownName, OutOfLimits
    """
    if drive in ARRANGEMENTS and (drive not in DRIVES or "wheel_radius" in geometry):
        try:
            base = ARRANGEMENTS.make(drive, geometry)
            known_parameters(base)
        except InputError as error:
            raise CalibrationError(str(error)) from None
        return Subject(drive, geometry, base)
    for name, value in geometry.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise CalibrationError(f"{name} is {value!r}; a number is needed")
    subject = Subject(drive, {name: float(value) for name, value in geometry.items()})
    subject.parameters()
    return subject


@dataclass(frozen=True, slots=True)
class OdometryLog:
    """Runs of one base.

    Attributes
    ----------
    source : file or folder it came from.
    drive : a key of `holonom.mobile.calibration.DRIVES`, or an arrangement of wheels.
    nominal : numbers of the drive, or arguments of the arrangement, as stated, m and rad.
    side : of the square that was driven, m; None for other paths, and where logs of several sides were joined.
    runs : in the order of the files.
    sides : the different ones of logs that were joined, m.
    bumped : names of the runs that went over bumps.
    base : wheels that a recording describes, where neither drive nor arrangement says them.
    notes : what a reader should know: runs that are missing, gaps that were let pass.
    """

    source: Path
    drive: str
    nominal: Mapping[str, Any]
    side: float | None
    runs: tuple[Run, ...]
    notes: tuple[str, ...] = ()
    sides: tuple[float, ...] = ()
    bumped: tuple[str, ...] = ()
    base: WheelBase | None = None

    @property
    def subject(self) -> Subject:
        """What was driven."""
        if self.base is not None:
            return Subject(self.drive, self.nominal, self.base)
        return subject_of(self.drive, self.nominal)
