"""PID as one difference equation: `u_k = a1 u_(k-1) + a2 u_(k-2) + b0 e_k + b1 e_(k-1) + b2 e_(k-2)`, limited."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PidSettings, Regulator
from holonom.control.regulators.kernels import pid_params
from holonom.registry import Method
from holonom.trace.code.loops import loop

__all__ = ["RECURSIVE", "RecursiveParams", "RecursiveSettings", "RecursiveState", "recursive_step"]


class RecursiveParams(NamedTuple):
    """Coefficients of the difference equation."""

    a1: float
    a2: float
    b0: float
    b1: float
    b2: float


class RecursiveState(NamedTuple):
    """The last two outputs that are remembered, the last two errors, last output."""

    u1: float
    u2: float
    e1: float
    e2: float
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RecursiveSettings(PidSettings):
    """Gains of the parallel form, made one difference equation.

    Raises
    ------
    OutOfLimits
        A number outside its range; of `params`: a derivative that the method cannot take without a filter.
    """

    def params(self, dt: float) -> RecursiveParams:
        """Params of `recursive_step`: P, I and D over their common denominator `(1 - 1/z)(1 - a/z)`."""
        p = pid_params(self, dt, (self.Kc, self.Kc / self.Ti, self.Kc * self.Td))
        a = p.fade
        return RecursiveParams(
            1.0 + a,
            -a,
            p.gain + p.now + p.rate,
            -p.gain * (1.0 + a) + p.before - a * p.now - 2.0 * p.rate,
            p.gain * a - a * p.before + p.rate,
        )


@loop
def recursive_step(
    params: RecursiveParams, state: RecursiveState, r: float, y: float, low: float, high: float
) -> tuple[float, RecursiveState]:
    """Output and next state; what is remembered is the limited output, so that nothing winds up."""
    e = r - y
    if not math.isfinite(e):
        return state.output, state
    wanted = params.b0 * e + params.b1 * state.e1 + params.b2 * state.e2 + params.a1 * state.u1 + params.a2 * state.u2
    u = min(max(wanted, low), high)
    return u, RecursiveState(u, state.u1, e, state.e1, u)


@loop
def recursive_start(params: RecursiveParams, u: float, r: float, y: float, low: float, high: float) -> RecursiveState:
    """State with which the next step at the same r and y gives u."""
    e = r - y
    memory = u - (params.b0 + params.b1 + params.b2) * e
    return RecursiveState(memory, memory, e, e, u)


RECURSIVE = Method(
    "PID with filter as one difference equation of the limited output; recoils",
    lambda settings: Regulator(recursive_step, recursive_start, settings, recoils=True),
    "Isermann, Digital Control Systems, 1989, ch. 5; specification 04.1",
    RecursiveSettings,
)
