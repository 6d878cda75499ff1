"""The table of devices: data sheets, each its own params record."""

from __future__ import annotations

from typing import Any

from holonom.devices.motors.cogging import Cogging
from holonom.devices.motors.dc_motor import DcMotor
from holonom.devices.motors.induction import InductionMachine, InductionMotor
from holonom.devices.motors.pmsm import Pmsm
from holonom.devices.motors.reluctance import SwitchedReluctance
from holonom.devices.motors.stepper import Stepper
from holonom.devices.motors.thermal import ThermalModel
from holonom.devices.power.bridge import PwmBridge
from holonom.devices.power.limiter import CurrentLimiter
from holonom.devices.power.supply import Supply
from holonom.devices.sensors.current import CurrentSensor
from holonom.devices.sensors.force import ForceSensor
from holonom.devices.sensors.inertial import Imu
from holonom.devices.sensors.tachometer import Tachometer
from holonom.devices.transmission.backlash import Backlash
from holonom.devices.transmission.dead_zone import DeadZone
from holonom.devices.transmission.friction import Friction
from holonom.devices.transmission.gear import Gear
from holonom.devices.transmission.harmonic import HarmonicDrive
from holonom.devices.transmission.lugre import LuGre
from holonom.devices.transmission.two_mass import TwoMass
from holonom.registry import Method, Table

__all__ = ["DEVICES"]


def _itself(sheet: Any) -> Any:
    """Return the data sheet: its record is what the device is made of."""
    return sheet


_CRAIG = "Craig, Introduction to Robotics, ch. 9"
_MOHAN = "Mohan, Undeland, Robbins, Power Electronics, 2003; spec 03.1"
_LEONHARD = "Leonhard, Control of Electrical Drives; spec 03.1"

DEVICES = Table(
    "devices",
    "device",
    "its data sheet, which makes the params of its compiled step",
    {
        "dc_motor": Method("permanent-magnet DC motor with its power stage", _itself, _CRAIG, DcMotor),
        "pmsm": Method("permanent-magnet synchronous or brushless motor", _itself, _LEONHARD, Pmsm),
        "stepper": Method("hybrid stepping motor", _itself, "Acarnley, Stepping Motors, 2002; spec 03.1", Stepper),
        "induction": Method("steady induction motor", _itself, "Kloss 1907; spec 03.1", InductionMotor),
        "induction_machine": Method("induction motor in space vectors", _itself, _LEONHARD, InductionMachine),
        "reluctance": Method(
            "switched reluctance motor",
            _itself,
            "Miller, Switched Reluctance Motors, 1993; spec 03.1",
            SwitchedReluctance,
        ),
        "cogging": Method("torque of the slots", _itself, "Hanselman, Brushless Motor Design, 2003, ch. 9", Cogging),
        "thermal": Method("winding and housing of a motor", _itself, "maxon, Key information; spec 03.1", ThermalModel),
        "pwm_bridge": Method("bridge of switches", _itself, _MOHAN, PwmBridge),
        "supply": Method("battery or rectifier with a DC link", _itself, _MOHAN, Supply),
        "current_limiter": Method("dead band in negative feedback", _itself, "000 3.6.1; spec 03.1", CurrentLimiter),
        "gear": Method("stiff gear without play, with its efficiency", _itself, _CRAIG, Gear),
        "harmonic_drive": Method(
            "harmonic drive with its stiffness in pieces and its error",
            _itself,
            "Tuttle, Seering, IEEE T-RA 12(3), 1996; spec 03.2",
            HarmonicDrive,
        ),
        "backlash": Method(
            "gap between flanks, or a preloaded pair",
            _itself,
            "Slotine, Li, Applied Nonlinear Control, 1991, 5.2; spec 03.2",
            Backlash,
        ),
        "dead_zone": Method("what moves nothing, and its inverse", _itself, "000 3.6; spec 03.5", DeadZone),
        "two_mass": Method(
            "motor and load at the ends of an elastic shaft",
            _itself,
            "Schröder, Elektrische Antriebe, Regelung von Antriebssystemen; spec 03.2",
            TwoMass,
        ),
        "friction": Method(
            "viscous and asymmetric Coulomb friction with Stribeck's curve",
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
        "tachometer": Method("voltage in proportion to speed, with its ripple", _itself, _LEONHARD, Tachometer),
        "current_sensor": Method("shunt with its amplifier and converter", _itself, _MOHAN, CurrentSensor),
        "imu": Method("gyros and accelerometers of three axes", _itself, "IEEE Std 952-1997; spec 03.4", Imu),
        "force_sensor": Method(
            "force and torque of six axes, with crosstalk",
            _itself,
            "Siciliano, Khatib, Springer Handbook of Robotics, ch. 28; spec 03.4",
            ForceSensor,
        ),
    },
)
