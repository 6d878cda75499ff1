"""PID with back-calculation: what was clipped flows back into the integral within the tracking time."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.regulators.contract import PidSettings, Regulator
from holonom.control.regulators.forms.pid_parallel import pid_start
from holonom.control.regulators.kernels import PidParams, PidState, pid_law, pid_params
from holonom.errors import OutOfLimits
from holonom.registry import Method, parameter
from holonom.trace.code.loops import loop

__all__ = ["BACK_CALCULATION", "BackSettings", "back_step"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BackSettings(PidSettings):
    """Gains of the parallel form, and the tracking time.

    Raises
    ------
    OutOfLimits
        A number outside its range; of `params`: a tracking time below the sample time or above Ti, a derivative that
        the method cannot take without a filter.
    """

    Tt: float | None = parameter(
        None, meaning="tracking time; none: Ti, with a derivative sqrt(Ti Td)", unit="s", above=0.0, most=math.inf
    )

    def params(self, dt: float) -> PidParams:
        """Params of `back_step` at a sample time, s."""
        rule = self.Ti if self.Td == 0.0 else math.sqrt(self.Ti * self.Td)
        tracking = max(rule, dt) if self.Tt is None else self.Tt
        if self.Tt is not None and not dt <= self.Tt <= self.Ti:
            raise OutOfLimits(f"Tt is {self.Tt!r} s; it must be from dt = {dt:g} s, below which it overshoots what was "
                              f"clipped, to Ti = {self.Ti:g} s, above which it winds up")  # fmt: skip
        gains = (self.Kc, self.Kc / self.Ti, self.Kc * self.Td)
        return pid_params(self, dt, gains, track=dt / tracking)


@loop
def back_step(
    params: PidParams, state: PidState, r: float, y: float, low: float, high: float
) -> tuple[float, PidState]:
    """Output and next state: `i += growth + T_s/T_t (u - v)`."""
    if not math.isfinite(r - y):
        return state.output, state
    law = pid_law(params, state, r, y)
    u = min(max(law.wanted, low), high)
    integral = state.integral + law.growth + params.track * (u - law.wanted)
    return u, PidState(integral, r - y, law.derivative, law.w, state.w1, state.w2, u)


BACK_CALCULATION = Method(
    "PID whose integral follows what was clipped within Tt; no recoil with Tt by its rule",
    lambda settings: Regulator(back_step, pid_start, settings, recoils=False),
    "Astrom, Hagglund, Advanced PID Control, 2006, 3.5; specification 04.5",
    BackSettings,
)
