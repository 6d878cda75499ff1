"""PID by increments (velocity form): `du = b0 e_k + b1 e_(k-1) + b2 e_(k-2)`, added to the last output."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PiSettings, Regulator
from holonom.registry import Method, parameter
from holonom.trace.code.loops import loop

__all__ = ["INCREMENTAL", "IncrementalParams", "IncrementalSettings", "IncrementalState", "incremental_step"]


class IncrementalParams(NamedTuple):
    """Coefficients of the increment."""

    b0: float
    b1: float
    b2: float


class IncrementalState(NamedTuple):
    """What the next increment is added to, the last two errors, last output."""

    memory: float
    e1: float
    e2: float
    output: float


@dataclass(frozen=True, slots=True, kw_only=True)
class IncrementalSettings(PiSettings):
    """Gains of the ideal PID.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    Td: float = parameter(0.0, meaning="derivative time", unit="s", least=0.0)

    def params(self, dt: float) -> IncrementalParams:
        """Params of `incremental_step` at a sample time, s (specification 04.1)."""
        i, d = dt / self.Ti, self.Td / dt
        return IncrementalParams(self.Kc * (1.0 + i + d), -self.Kc * (1.0 + 2.0 * d), self.Kc * d)


@loop
def incremental_step(
    params: IncrementalParams, state: IncrementalState, r: float, y: float, low: float, high: float
) -> tuple[float, IncrementalState]:
    """Output and next state; the memory is the limited output, so that nothing winds up."""
    e = r - y
    if not math.isfinite(e):
        return state.output, state
    wanted = state.memory + params.b0 * e + params.b1 * state.e1 + params.b2 * state.e2
    u = min(max(wanted, low), high)
    return u, IncrementalState(u, e, state.e1, u)


@loop
def incremental_start(
    params: IncrementalParams, u: float, r: float, y: float, low: float, high: float
) -> IncrementalState:
    """State with which the next step at the same r and y gives u."""
    e = r - y
    return IncrementalState(u - (params.b0 + params.b1 + params.b2) * e, e, e, u)


INCREMENTAL = Method(
    "ideal PID by backward differences, added to the last limited output; recoils",
    lambda settings: Regulator(incremental_step, incremental_start, settings, recoils=True),
    "Isermann, Digital Control Systems, 1989, ch. 5; specification 04.1",
    IncrementalSettings,
)
