"""Settings of a base's controller: which parts it has, and their numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Literal

from holonom.control.balance.contract import BalanceLaw
from holonom.control.balance.lqr import LqrBalance
from holonom.control.base.inertial_check import CheckSettings
from holonom.control.base.path_keeping import EstimateSettings, KeepingSettings
from holonom.control.base.shaping import ShapingSettings
from holonom.control.base.traction import TractionSettings, WatchSettings
from holonom.errors import OutOfLimits, UnknownName
from holonom.machine.base.laws import Law
from holonom.mobile.drive.base_drive import BaseDrive, BaseSensors
from holonom.mobile.drive.slip import SlipSettings

__all__ = ["KEEP", "BaseSettings", "Creep", "slip_settings"]

CREEP_ERROR = 0.003  # m/s, standard deviation of what is not known of a gripping wheel's creep
COUNT_RATE = 120.0  # 1/s, standard deviation of measured speed per encoder count, through the wheels' observer
LEAST_RATE_NOISE = 2e-3  # rad/s
KEEP = ("both", "path", "heading")
"""What a base keeps once the motors that are left cannot hold path and heading at once."""
TILT = 0.1  # m/s2, of a floor that is not quite level


@dataclass(frozen=True, slots=True)
class Creep:
    """What the controller knows of gripping wheels: they creep, the more the harder they push.

    Attributes
    ----------
    slope
        Slip speed (m/s) over the part of the load that is pushed with, where both are small.
    grip
        Largest part of the load that a wheel can push with.

    Raises
    ------
    OutOfLimits
        A negative slope, a grip that is not positive.
    """

    slope: float
    grip: float

    def __post_init__(self) -> None:
        if not (0.0 <= self.slope < math.inf and 0.0 < self.grip < math.inf):
            raise OutOfLimits(
                f"Creep: slope is {self.slope!r} m/s, grip {self.grip!r}; slope must be at least 0, grip above 0"
            )


def slip_settings(sensors: BaseSensors, drive: BaseDrive, radius: float = 0.03) -> SlipSettings:
    """Slip detection for sensors, encoders and a wheel radius (m): what is noise to them is none of a slipping wheel.

    Rim speed: an encoder count, through the observer of the wheel's speed, beside what the creep of a gripping wheel
    is known to. Gyro and accelerometers: what they state, at least what good ones have, and a floor that is not quite
    level; in 10 ms noise averages out to a third.
    """
    count = radius * 2.0 * math.pi / drive.encoder.counts_per_rev / abs(drive.gear.ratio)
    return SlipSettings(
        noise=math.hypot(CREEP_ERROR, count * COUNT_RATE),
        rate_noise=max(sensors.gyro_noise, LEAST_RATE_NOISE),
        rate_bias=abs(sensors.gyro_bias) + LEAST_RATE_NOISE,
        max_acceleration=8.0,
        max_angular_acceleration=150.0,
        acceleration_error=abs(sensors.accelerometer_bias) + sensors.accelerometer_noise / 3.0 + TILT,
        angular_acceleration_error=math.inf,
        persistence=0.012,
        confirmation=0.006,
    )


@dataclass(frozen=True, slots=True)
class BaseSettings:
    """Parts of a base's controller; None switches traction control, slip detection or the watch over the motors off.

    Attributes
    ----------
    keeping, shaping, estimate, traction, watch
        Their settings.
    sensors
        What is known of the errors of its sensors.
    slip
        Settings of slip detection; "sensors": `slip_settings` of these sensors and the drive's encoders.
    check
        How wheels without a spare one are checked by inertia, where slip is detected at all; None: they are not.
    creep
        What is known of gripping wheels; None: what whoever knows the floor says of it. What wheels creep at their
        present currents is no slip.
    keep
        One of `KEEP`: what is kept where lost motors leave only one of them. "both" asks for both, and gets neither.
    law
        What `PATH_LAWS` makes: how a base that cannot move sideways keeps its path; None: Kanayama's with the gains of
        `keeping`.
    balance
        Law of a body that balances; None: it is held upright, by ideal drives.
    friction
        Friction coefficient that the force asked of a wheel counts on.

    Raises
    ------
    OutOfLimits
        A friction coefficient that is not positive.
    """

    keeping: KeepingSettings = field(default_factory=KeepingSettings)
    shaping: ShapingSettings = field(default_factory=ShapingSettings)
    estimate: EstimateSettings = field(default_factory=EstimateSettings)
    traction: TractionSettings | None = field(default_factory=TractionSettings)
    slip: SlipSettings | Literal["sensors"] | None = "sensors"
    check: CheckSettings | None = field(default_factory=CheckSettings)
    watch: WatchSettings | None = field(default_factory=WatchSettings)
    sensors: BaseSensors = field(default_factory=BaseSensors)
    friction: float = 0.6
    creep: Creep | None = None
    keep: str = "both"
    law: Law | None = None
    balance: BalanceLaw | None = field(default_factory=LqrBalance)

    def without_motors(self) -> BaseSettings:
        """Return the settings for drives that turn as they are told: no current tells of slip or of lost motors."""
        return replace(self, slip=None, check=None, traction=None, watch=None, balance=None)

    def __post_init__(self) -> None:
        if not 0.0 < self.friction < math.inf:
            raise OutOfLimits(f"BaseSettings: friction is {self.friction!r}; it must be finite and greater than 0")
        if self.keep not in KEEP:
            raise UnknownName("thing to keep", self.keep, KEEP)
