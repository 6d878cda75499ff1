"""Holding brake: closed without power, with the delays of its coil (spec 03.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["Brake", "BrakeParams", "BrakeState", "brake_step"]


class BrakeParams(NamedTuple):
    """Steps until it holds after it is told to, and until it is free; its torque, N m."""

    engage: int
    release: int
    torque: float


class BrakeState(NamedTuple):
    """Whether it holds (1 or 0), and for how many steps it has been told otherwise."""

    closed: int
    told: int


@dataclass(frozen=True, slots=True)
class Brake:
    """A brake on the motor's shaft, closed by springs and opened by current.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    torque: float = parameter(meaning="greatest that it holds, at the motor", unit="N m", above=0.0, example=0.5)
    engage: float = parameter(0.02, meaning="until it holds, after the power is off", unit="s", least=0.0)
    release: float = parameter(0.03, meaning="until it is free, after the power is on", unit="s", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self, dt: float) -> BrakeParams:
        """Params of `brake_step` for a step of `dt` (s)."""
        require("Brake.params", "dt", dt, above=0.0)
        return BrakeParams(round(self.engage / dt), round(self.release / dt), self.torque)


@loop(forceinline=True)
def brake_step(params: BrakeParams, state: BrakeState, close: int) -> BrakeState:
    """One step in which it is told to close (1) or to open (0)."""
    if close == state.closed:
        return BrakeState(state.closed, 0)
    told = state.told + 1
    if told >= (params.engage if close else params.release):
        return BrakeState(close, 0)
    return BrakeState(state.closed, told)
