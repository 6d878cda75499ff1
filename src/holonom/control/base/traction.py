"""Settings of traction control and of the watch over the motors."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.base.kernels import TractionParams, WatchParams
from holonom.errors import OutOfLimits
from holonom.registry import check_fields, parameter

__all__ = ["TractionSettings", "WatchSettings"]


@dataclass(frozen=True, slots=True)
class TractionSettings:
    """How much slip is wanted; laws in `control.base.kernels.traction_step` and `within_slip`.

    Friction peaks between the two slips.

    Raises
    ------
    OutOfLimits
        Not `0 < free_slip < max_slip`, or a time that is not positive.
    """

    free_slip: float = parameter(0.06, meaning="slip that is left alone", unit="m/s", above=0.0)
    max_slip: float = parameter(0.15, meaning="largest slip that a wheel is sent to", unit="m/s", above=0.0)
    cut_time: float = parameter(
        0.02, meaning="to take away a wheel's drive force at the largest slip", unit="s", above=0.0
    )
    recovery_time: float = parameter(0.2, meaning="to give it back", unit="s", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self)
        if not self.free_slip < self.max_slip:
            raise OutOfLimits(
                f"TractionSettings: free_slip {self.free_slip!r}, max_slip {self.max_slip!r} m/s; "
                "needed is free_slip < max_slip"
            )

    def params(self, dt: float) -> TractionParams:
        """Params of `traction_step` at a sample time, s."""
        return TractionParams(dt, self.free_slip, self.max_slip, 1.0 / self.cut_time, 1.0 / self.recovery_time)


@dataclass(frozen=True, slots=True)
class WatchSettings:
    """When a motor counts as dead or jammed; laws in `control.base.kernels.watch_step` and `watch_verdict`.

    The least current is several times the noise of the shunt, standstill the noise of an encoder count. A wheel of a
    base that others push may pass through standstill against its command; one that is jammed stays there. The floor can
    hold a wheel against about the holding current.

    Raises
    ------
    OutOfLimits
        A number that is not positive, a part of 1 and more, a doubt above 1.
    """

    least_current: float = parameter(0.25, meaning="smaller modelled currents prove nothing", unit="A", above=0.0)
    least_part: float = parameter(
        0.3, meaning="of the modelled current, what a live motor draws at least", above=0.0, below=1.0
    )
    standstill: float = parameter(0.4, meaning="slower motors stand", unit="rad/s", above=0.0)
    least_reference: float = parameter(15.0, meaning="faster commands prove something", unit="rad/s", above=0.0)
    patience: float = parameter(0.03, meaning="evidence for an open winding", unit="s", above=0.0)
    jam_patience: float = parameter(0.04, meaning="evidence for a jam", unit="s", above=0.0)
    holding_current: float = parameter(3.0, meaning="with more of it a free wheel turns", unit="A", above=0.0)
    doubt: float = parameter(
        0.25,
        meaning="part of the time that counts for a jam while others' slip may explain it",
        above=0.0,
        most=1.0,
    )

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, dt: float) -> WatchParams:
        """Params of `watch_step` at a sample time, s."""
        return WatchParams(
            dt, self.least_current, self.least_part, self.standstill, self.least_reference,
            self.patience, self.jam_patience, self.holding_current, self.doubt,
        )  # fmt: skip
