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
    """When a motor counts as dead or jammed; laws in `control.base_kernels.watch_step` and `watch_verdict`.

    Attributes
    ----------
    least_current
        A: smaller modelled currents prove nothing. Several times the noise of the shunt.
    least_part
        Part of the modelled current that a live motor draws at least.
    standstill, least_reference
        rad/s of the motor: slower is standing, the noise of an encoder count; faster a command proves something.
    patience, jam_patience
        s of evidence for an open winding, and for a jam. A wheel of a base that others push may pass through standstill
        against its command; one that is jammed stays there.
    holding_current
        A, about as much as the floor can hold a wheel against: with more of it a wheel that is not jammed turns.
    doubt
        Part of the time that counts as evidence of a jam while the slip of other wheels may explain it.

    Raises
    ------
    OutOfLimits
        A number that is not positive, a part of 1 and more, a doubt above 1.
    """

    least_current: float = 0.25
    least_part: float = 0.3
    standstill: float = 0.4
    least_reference: float = 15.0
    patience: float = 0.03
    jam_patience: float = 0.04
    holding_current: float = 3.0
    doubt: float = 0.25

    def __post_init__(self) -> None:
        if not 0.0 < self.least_part < 1.0:
            raise OutOfLimits(f"WatchSettings: least_part is {self.least_part!r}; it must lie between 0 and 1")
        _times(
            "WatchSettings",
            least_current=self.least_current,
            standstill=self.standstill,
            least_reference=self.least_reference,
            patience=self.patience,
            jam_patience=self.jam_patience,
            holding_current=self.holding_current,
            doubt=self.doubt,
        )
        if self.doubt > 1.0:
            raise OutOfLimits(f"WatchSettings: doubt is {self.doubt!r}; it must be above 0 and at most 1")

    def params(self, dt: float) -> WatchParams:
        """Params of `watch_step` at a sample time, s."""
        return WatchParams(
            dt, self.least_current, self.least_part, self.standstill, self.least_reference,
            self.patience, self.jam_patience, self.holding_current, self.doubt,
        )  # fmt: skip


def _times(owner: str, **values: float) -> None:
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            raise OutOfLimits(f"{owner}: {name} is {value!r}; it must be finite and greater than 0")
