"""Tables of devices and of the sensors that are devices: data sheets, each its own params record."""

from __future__ import annotations

from typing import Any

from holonom.devices.dc_motor import DcMotor
from holonom.devices.encoder import Encoder
from holonom.devices.friction import Friction
from holonom.devices.gear import Gear
from holonom.devices.sensors import Accelerometer, CurrentShunt, Gyro
from holonom.registry import Method, Table

__all__ = ["DEVICES", "SENSORS"]


def _itself(sheet: Any) -> Any:
    """Return the data sheet: its record is what the device is made of."""
    return sheet


_CRAIG = "Craig, Introduction to Robotics, ch. 9"
_GROVES = "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, ch. 4"

DEVICES = Table(
    "devices",
    "device",
    "its data sheet, which makes the params of its compiled step",
    {
        "dc_motor": Method("permanent-magnet DC motor with its power stage", _itself, _CRAIG, DcMotor),
        "gear": Method("stiff gear without play", _itself, _CRAIG, Gear),
        "friction": Method(
            "viscous and asymmetric Coulomb friction",
            _itself,
            "Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994",
            Friction,
        ),
    },
)

SENSORS = Table(
    "sensors",
    "sensor",
    "its data sheet",
    {
        "encoder": Method("counts of a motor's shaft", _itself, "Craig, Introduction to Robotics, 8.8", Encoder),
        "gyro": Method("turning rate about the vertical, with noise and offset", _itself, _GROVES, Gyro),
        "accelerometer": Method("acceleration along x and y, with noise and offset", _itself, _GROVES, Accelerometer),
        "current_shunt": Method(
            "armature current, with noise", _itself, "Leonhard, Control of Electrical Drives", CurrentShunt
        ),
    },
)
