"""How wheels of a base without a spare one are checked: by gyro and accelerometers, and by what their motors push."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from holonom.registry import check_fields, parameter

__all__ = ["EVERY", "CheckParams", "CheckSettings", "PushParams"]

EVERY = 8
"""Samples of which the watch over what wheels push looks at one."""


class CheckParams(NamedTuple):
    """Of the compiled check; as in `CheckSettings`, times in samples where they count."""

    dt: float
    bound: float
    turn: float
    drift: float
    blend: float
    learning: float
    persistence: int
    release: int
    patience: float


class PushParams(NamedTuple):
    """Of the watch over what wheels push; as in `CheckSettings`, at a time of `EVERY` samples."""

    dt: float
    least_push: float
    push: float
    loose: float
    idle: float


@dataclass(frozen=True, slots=True)
class CheckSettings:
    """Slip of wheels that determine the twist alone, by sensors of inertia; laws in `machine.base.check_kernels`.

    Velocity by the accelerometers is blended with that by the wheels; a rim that is farther from it than bound, drift
    and turn allow, slips. Wheels of any base that push nothing are off: their motors' torque only turns them.

    Raises
    ------
    OutOfLimits
    """

    bound: float = parameter(0.12, meaning="difference of a rim that is none", unit="m/s", above=0.0)
    turn: float = parameter(0.05, meaning="how far the gyro may be off", unit="rad/s", least=0.0)
    drift: float = parameter(0.5, meaning="how far the accelerometers may be off", unit="m/s2", least=0.0)
    blend: float = parameter(8.0, meaning="pull of wheels that grip", unit="1/s", above=0.0)
    learning: float = parameter(4.0, meaning="of the accelerometers' zero and slopes", unit="1/s2", least=0.0)
    persistence: float = parameter(0.015, meaning="how long slip lasts before it is raised", unit="s", above=0.0)
    release: float = parameter(0.03, meaning="how long a wheel grips before it is believed again", unit="s", above=0.0)
    patience: float = parameter(1.0, meaning="after which accelerometers alone tell nothing", unit="s", above=0.0)
    least_push: float = parameter(
        0.1, meaning="part of its largest force that says something when asked", above=0.0, below=1.0
    )
    push: float = parameter(0.2, meaning="part of what is asked that a wheel pushes at least", above=0.0, below=1.0)
    loose: float = parameter(2.0, meaning="slip that lasts longer is no ice", unit="s", above=0.0)
    idle: float = parameter(
        0.3, meaning="how long a wheel pushes nothing either way until it is off", unit="s", above=0.0
    )

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, dt: float) -> CheckParams:
        """Params of the check at a sample time, s."""
        return CheckParams(
            dt, self.bound, self.turn, self.drift, self.blend, self.learning, max(round(self.persistence / dt), 1),
            max(round(self.release / dt), 1), self.patience,
        )  # fmt: skip

    def pushes(self, dt: float) -> PushParams:
        """Params of the watch over pushes at a sample time, s."""
        return PushParams(EVERY * dt, self.least_push, self.push, self.loose, self.idle)
