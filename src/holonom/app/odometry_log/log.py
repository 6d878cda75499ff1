"""What a log of odometry holds once it is read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from holonom.mobile.calibration import Run

__all__ = ["OdometryLog"]


@dataclass(frozen=True, slots=True)
class OdometryLog:
    """Runs of one base.

    Attributes
    ----------
    source : file or folder it came from.
    drive : a key of `holonom.mobile.calibration.DRIVES`.
    nominal : the base's physical parameters as stated, m and rad.
    side : of the square that was driven, m; None for other paths, and where logs of several sides were joined.
    runs : in the order of the files.
    sides : the different ones of logs that were joined, m.
    notes : what a reader should know: runs that are missing, gaps that were let pass.
    """

    source: Path
    drive: str
    nominal: Mapping[str, float]
    side: float | None
    runs: tuple[Run, ...]
    notes: tuple[str, ...] = ()
    sides: tuple[float, ...] = ()
