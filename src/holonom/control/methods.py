"""Tables of controllers: joint controllers of an arm, parts of a base's controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from holonom.control.base.path_keeping import EstimateSettings, KeepingSettings
from holonom.control.base.traction import TractionSettings, WatchSettings
from holonom.registry import OWN, Method, Table, check_fields, parameter

__all__ = ["BASE_CONTROLLERS", "CONTROLLERS", "CascadeSettings", "ComputedTorqueSettings"]


@dataclass(frozen=True, slots=True)
class CascadeSettings:
    """Position, speed and current loop of each axis, whose gains follow from motor and load (`design_cascade`)."""


@dataclass(frozen=True, slots=True)
class ComputedTorqueSettings:
    """The computed-torque law.

    Raises
    ------
    OutOfLimits
    """

    law_bandwidth: float = parameter(50.0, meaning="poles of the error equation", unit="rad/s", above=0.0, most=100.0)

    def __post_init__(self) -> None:
        check_fields(self)


def _itself(settings: Any) -> Any:
    """Return the settings, from which a machine makes its compiled loop."""
    return settings


CONTROLLERS = Table(
    "controllers",
    "controller",
    "its settings, of which the loops of an arm's axes are made",
    {
        "cascade": Method(
            "position, speed and current loops, one inside the other",
            _itself,
            "Leonhard, Control of Electrical Drives; specification 04.2",
            CascadeSettings,
        ),
        "computed_torque": Method(
            "inverse dynamics with a linear error equation around it",
            _itself,
            "Craig, Introduction to Robotics, ch. 10; specification 04.4",
            ComputedTorqueSettings,
        ),
    },
)

_OMNI = "Rojas, Foerster, Holonomic Control of a robot with an omnidirectional drive; specification 06.2"
_HERE = f"{OWN}; specification 06.2"

BASE_CONTROLLERS = Table(
    "base_controllers",
    "part of a base's controller",
    "its settings, whose `params(dt)` are those of its compiled step",
    {
        "path_keeping": Method("feed-forward and PI on the pose error", _itself, _OMNI, KeepingSettings),
        "velocity_estimate": Method(
            "velocity from gyro, accelerometers and the wheels that are trusted", _itself, _HERE, EstimateSettings
        ),
        "traction_control": Method("cut the force of a wheel that slips", _itself, _HERE, TractionSettings),
        "motor_watch": Method("find a dead or jammed motor", _itself, _HERE, WatchSettings),
    },
)
