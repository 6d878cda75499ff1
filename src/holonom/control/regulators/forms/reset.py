"""PI with integrator reset: what was clipped is taken out of the integral, by the tracking gain g."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PiSettings, Regulator
from holonom.registry import Method, parameter
from holonom.trace.code.loops import loop

__all__ = ["RESET", "ResetParams", "ResetSettings", "ResetState", "reset_step"]


class ResetParams(NamedTuple):
    """`K_c`, `K_i = K_c T_s/T_i`, tracking gain."""

    gain: float
    integral_gain: float
    tracking: float


class ResetState(NamedTuple):
    """Integral and last output."""

    integral: float
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ResetSettings(PiSettings):
    """Gains and tracking gain; below `T_s/T_i` this form winds up.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    g: float = parameter(1.0, meaning="tracking gain: part of what was clipped that is taken back", above=0.0, most=1.0)

    def params(self, dt: float) -> ResetParams:
        """Params of `reset_step` at a sample time, s."""
        return ResetParams(self.Kc, self.Kc * dt / self.Ti, self.g)


@loop
def reset_step(
    params: ResetParams, state: ResetState, r: float, y: float, low: float, high: float
) -> tuple[float, ResetState]:
    """Output and next state: `i += K_i e; v = K_c e + i; u = clip(v); i += g (u - v)` (specification 04.1)."""
    e = r - y
    if not math.isfinite(e):
        return state.output, state
    integral = state.integral + params.integral_gain * e
    wanted = params.gain * e + integral
    u = min(max(wanted, low), high)
    return u, ResetState(integral + params.tracking * (u - wanted), u)


@loop
def reset_start(params: ResetParams, u: float, r: float, y: float, low: float, high: float) -> ResetState:
    """State with which the next step at the same r and y gives u."""
    return ResetState(u - (params.gain + params.integral_gain) * (r - y), u)


RESET = Method(
    "PI that takes what was clipped out of its integral; recoils",
    lambda settings: Regulator(reset_step, reset_start, settings, recoils=True),
    "Fertik, Ross, Direct digital control algorithm with anti-windup feature, ISA Trans. 6, 1967; specification 04.1",
    ResetSettings,
)
