"""The table of sensors: what measures a simulated robot or its work pieces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from holonom.devices import Accelerometer, CurrentShunt, Encoder, Gyro
from holonom.registry import Method, Table, check_fields, parameter

__all__ = ["SENSORS", "CameraPoints"]


@dataclass(frozen=True, slots=True)
class CameraPoints:
    """What a camera over a table is calibrated from: four points or more, seen and measured."""

    pixels: tuple[tuple[float, float], ...] = parameter(
        meaning="u and v of each point", unit="px", example=((0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0))
    )
    points: tuple[tuple[float, float], ...] = parameter(
        meaning="x and y of the same points", unit="m", example=((0.0, 0.1), (0.1, 0.1), (0.1, 0.0), (0.0, 0.0))
    )
    tolerance: float = parameter(2e-3, meaning="distance within which a point agrees", unit="m", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self)


def _camera(points: CameraPoints) -> Any:
    """Return the `TableCamera`; OpenCV is imported when one is made."""
    from holonom.vision import fit_homography

    return fit_homography(points.pixels, points.points, tolerance_mm=1e3 * points.tolerance)


def _itself(sheet: Any) -> Any:
    """Return the data sheet: its record is what the plant's measurements are made of."""
    return sheet


_GROVES = "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, ch. 4"

SENSORS = Table(
    "sensors",
    "sensor",
    "its data sheet; of a camera its `TableCamera`",
    {
        "encoder": Method("counts of a motor's shaft", _itself, "Craig, Introduction to Robotics, 8.8", Encoder),
        "gyro": Method("turning rate about the vertical, with noise and offset", _itself, _GROVES, Gyro),
        "accelerometer": Method("acceleration along x and y, with noise and offset", _itself, _GROVES, Accelerometer),
        "current_shunt": Method(
            "armature current, with noise", _itself, "Leonhard, Control of Electrical Drives", CurrentShunt
        ),
        "camera": Method(
            "a camera over a flat table",
            _camera,
            "Hartley, Zisserman, Multiple View Geometry, 4.1, 4.2, 4.6",
            CameraPoints,
        ),
    },
)
