"""PID in parallel form: `u/e = K_c (1 + 1/(s T_i) + s T_d/(1 + s T))`."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.regulators.contract import PidSettings, Regulator
from holonom.control.regulators.kernels import PidParams, PidState, pid_law, pid_params, pid_rest
from holonom.registry import Method, parameter
from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop

__all__ = ["PID_PARALLEL", "ParallelSettings", "pid_start", "pid_step"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ParallelSettings(PidSettings):
    """Gains of the parallel form.

    Raises
    ------
    OutOfLimits
        A number outside its range; of `params`: a derivative that the method cannot take without a filter.
    """

    four_samples: bool = parameter(False, meaning="whether the derivative is taken over four samples instead of two")

    def params(self, dt: float) -> PidParams:
        """Params of `pid_step` at a sample time, s."""
        return pid_params(self, dt, (self.Kc, self.Kc / self.Ti, self.Kc * self.Td), four=self.four_samples)


@loop
def pid_step(params: PidParams, state: PidState, r: float, y: float, low: float, high: float) -> tuple[float, PidState]:
    """Output and next state; the integral stands still where the output is at a limit and it would push further."""
    if not math.isfinite(r - y):
        return state.output, state
    law = pid_law(params, state, r, y)
    u = min(max(law.wanted, low), high)
    integral = state.integral + select((law.wanted - u) * law.growth > 0.0, 0.0, law.growth)
    return u, PidState(integral, r - y, law.derivative, law.w, state.w1, state.w2, u)


@loop
def pid_start(params: PidParams, u: float, r: float, y: float, low: float, high: float) -> PidState:
    """State with which the next step at the same r and y gives u."""
    return pid_rest(params, u, r, y)


PID_PARALLEL = Method(
    "P, I and filtered D side by side, conditional integration; no recoil",
    lambda settings: Regulator(pid_step, pid_start, settings, recoils=False),
    "Astrom, Hagglund, Advanced PID Control, 2006, ch. 3; specification 04.1",
    ParallelSettings,
)
