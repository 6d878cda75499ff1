"""PI with conditional integration: the servo's own regulator (`control.servo.kernels.pi_step`)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PiSettings, Regulator
from holonom.control.servo.kernels import PiParams, pi_start, pi_step
from holonom.registry import Method
from holonom.trace.code.loops import loop

__all__ = ["CONDITIONAL", "ConditionalSettings", "ConditionalState", "conditional_step"]


class ConditionalState(NamedTuple):
    """Integral and last output."""

    integral: float
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ConditionalSettings(PiSettings):
    """Gain and integral time.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    def params(self, dt: float) -> PiParams:
        """Params of `conditional_step` at a sample time, s."""
        return PiParams(self.Kc, self.Kc * dt / self.Ti)


@loop
def conditional_step(
    params: PiParams, state: ConditionalState, r: float, y: float, low: float, high: float
) -> tuple[float, ConditionalState]:
    """Output and next state; the integral stands still where the output is at a limit and the error pushes further."""
    e = r - y
    if not math.isfinite(e):
        return state.output, state
    u, integral = pi_step(params, state.integral, e, 0.0, low, high)
    return u, ConditionalState(integral, u)


@loop
def conditional_start(params: PiParams, u: float, r: float, y: float, low: float, high: float) -> ConditionalState:
    """State with which the next step at the same r and y gives u."""
    return ConditionalState(pi_start(params, u, r - y, 0.0), u)


CONDITIONAL = Method(
    "PI whose integral stands still at a limit, the servo's own; no recoil",
    lambda settings: Regulator(conditional_step, conditional_start, settings, recoils=False),
    "Astrom, Hagglund, Advanced PID Control, 2006, 3.5; specification 04.1",
    ConditionalSettings,
)
