"""What a cell's base does not know of its pose."""

from __future__ import annotations

from holonom.app.base.assembly import BaseJob
from holonom.control.base_uncertainty import UncertaintySettings
from holonom.control.path_keeping import EstimateSettings
from holonom.machine.base.settings import Creep
from holonom.machine.base.uncertainty import pose_uncertainty
from holonom.mobile import BaseSensors

__all__ = ["uncertainty"]


def uncertainty(job: BaseJob) -> UncertaintySettings:
    """Return the settings for a cell's base: creep as on the floor's own material."""
    gyro, material = job.cell.gyro, job.floor.material
    sensors = BaseSensors(gyro.noise, gyro.bias, gyro.acceleration_noise)
    creep = Creep(material.creep, material.peak or 1.0)
    return pose_uncertainty(job.base, job.drive, sensors, creep, EstimateSettings())
