"""Robot files that packages ship, as far as they are installed here."""

from __future__ import annotations

import sys
from pathlib import Path

__all__ = ["shipped_robots"]

PACKAGES = ("cmeel.prefix/share/example-robot-data/robots", "rtbdata/xacro")


def shipped_robots(data_folder: Path) -> list[Path]:
    """URDFs of the data folder and of the packages example-robot-data and rtb-data, where there are any."""
    folders = [data_folder / "robots" / "urdf", *(Path(place) / package for place in sys.path for package in PACKAGES)]
    return sorted({file.resolve() for folder in folders for file in folder.rglob("*.urdf")})
