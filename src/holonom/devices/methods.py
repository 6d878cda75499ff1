"""The table of devices: data sheets, each its own params record."""

from __future__ import annotations

from typing import Any

from holonom.devices.motors.dc_motor import DcMotor
from holonom.devices.motors.thermal import ThermalModel
from holonom.devices.transmission.friction import Friction
from holonom.devices.transmission.gear import Gear
from holonom.devices.transmission.lugre import LuGre
from holonom.registry import Method, Table

__all__ = ["DEVICES"]


def _itself(sheet: Any) -> Any:
    """Return the data sheet: its record is what the device is made of."""
    return sheet


_CRAIG = "Craig, Introduction to Robotics, ch. 9"

DEVICES = Table(
    "devices",
    "device",
    "its data sheet, which makes the params of its compiled step",
    {
        "dc_motor": Method("permanent-magnet DC motor with its power stage", _itself, _CRAIG, DcMotor),
        "thermal": Method("winding and housing of a motor", _itself, "maxon, Key information; spec 03.1", ThermalModel),
        "gear": Method("stiff gear without play", _itself, _CRAIG, Gear),
        "friction": Method(
            "viscous and asymmetric Coulomb friction",
            _itself,
            "Armstrong-Helouvry, Dupont, Canudas de Wit, Automatica 30(7), 1994",
            Friction,
        ),
        "lugre": Method(
            "bristles that bend before they slip: stick-slip, presliding, Stribeck's curve",
            _itself,
            "Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40(3), 1995; specification 03.2",
            LuGre,
        ),
    },
)
