"""PI as its maker built it: positive feedback of the limited output through a lag of the integral time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PiSettings, Regulator
from holonom.registry import Method
from holonom.trace.code.loops import loop

__all__ = ["FOXBORO", "FoxboroParams", "FoxboroSettings", "FoxboroState", "foxboro_step"]


class FoxboroParams(NamedTuple):
    """`K_c` and `1 - beta`, `beta = exp(-T_s/T_i)`."""

    gain: float
    part: float


class FoxboroState(NamedTuple):
    """The lag's output and the last output."""

    lag: float
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FoxboroSettings(PiSettings):
    """Gain and integral time.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    def params(self, dt: float) -> FoxboroParams:
        """Params of `foxboro_step` at a sample time, s."""
        return FoxboroParams(self.Kc, -math.expm1(-dt / self.Ti))


@loop
def foxboro_step(
    params: FoxboroParams, state: FoxboroState, r: float, y: float, low: float, high: float
) -> tuple[float, FoxboroState]:
    """Output and next state: `u = clip(K_c e + f); f = beta f + (1 - beta) u` (specification 04.1)."""
    e = r - y
    if not math.isfinite(e):
        return state.output, state
    u = min(max(params.gain * e + state.lag, low), high)
    return u, FoxboroState(state.lag + params.part * (u - state.lag), u)


@loop
def foxboro_start(params: FoxboroParams, u: float, r: float, y: float, low: float, high: float) -> FoxboroState:
    """State with which the next step at the same r and y gives u."""
    return FoxboroState(u - params.gain * (r - y), u)


FOXBORO = Method(
    "PI by positive feedback of the limited output through a lag; no recoil",
    lambda settings: Regulator(foxboro_step, foxboro_start, settings, recoils=False),
    "Shinskey, Process Control Systems, 1967; specification 04.1",
    FoxboroSettings,
)
