"""Settings of traction control and of the watch over the motors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.base_kernels import TractionParams, WatchParams
from holonom.errors import OutOfLimits

__all__ = ["TractionSettings", "WatchSettings"]


@dataclass(frozen=True, slots=True)
class TractionSettings:
    """How much slip is wanted; laws in `control.base_kernels.traction_step` and `within_slip`.

    Attributes
    ----------
    free_slip, max_slip
        m/s: slip that is left alone, and the largest that a wheel is sent to; friction peaks between them.
    cut_time, recovery_time
        s, to take away a wheel's drive force at the largest slip, and to give it back.

    Raises
    ------
    OutOfLimits
        Not `0 < free_slip < max_slip`, or a time that is not positive.
    """

    free_slip: float = 0.06
    max_slip: float = 0.15
    cut_time: float = 0.02
    recovery_time: float = 0.2

    def __post_init__(self) -> None:
        if not 0.0 < self.free_slip < self.max_slip < math.inf:
            raise OutOfLimits(
                f"TractionSettings: free_slip {self.free_slip!r}, max_slip {self.max_slip!r} m/s; "
                "needed is 0 < free_slip < max_slip"
            )
        _times("TractionSettings", cut_time=self.cut_time, recovery_time=self.recovery_time)

    def params(self, dt: float) -> TractionParams:
        """Params of `traction_step` at a sample time, s."""
        return TractionParams(dt, self.free_slip, self.max_slip, 1.0 / self.cut_time, 1.0 / self.recovery_time)


@dataclass(frozen=True, slots=True)
class WatchSettings:
    """When a motor counts as dead; law in `control.base_kernels.watch_step`.

    Attributes
    ----------
    least_current
        A: smaller modelled currents prove nothing. Several times the noise of the shunt.
    least_part
        Part of the modelled current that a live motor draws at least.
    standstill, least_reference
        rad/s of the motor: slower is standing; faster a command proves something.
    patience
        s of evidence.

    Raises
    ------
    OutOfLimits
        A number that is not positive, or a part of 1 and more.
    """

    least_current: float = 0.25
    least_part: float = 0.3
    standstill: float = 2.0
    least_reference: float = 20.0
    patience: float = 0.03

    def __post_init__(self) -> None:
        if not 0.0 < self.least_part < 1.0:
            raise OutOfLimits(f"WatchSettings: least_part is {self.least_part!r}; it must lie between 0 and 1")
        _times(
            "WatchSettings",
            least_current=self.least_current,
            standstill=self.standstill,
            least_reference=self.least_reference,
            patience=self.patience,
        )

    def params(self, dt: float) -> WatchParams:
        """Params of `watch_step` at a sample time, s."""
        return WatchParams(
            dt, self.least_current, self.least_part, self.standstill, self.least_reference, self.patience
        )


def _times(owner: str, **values: float) -> None:
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            raise OutOfLimits(f"{owner}: {name} is {value!r}; it must be finite and greater than 0")
