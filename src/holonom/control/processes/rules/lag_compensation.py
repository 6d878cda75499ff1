"""Lag compensation: the regulator's zero on the lag, what is left is an integrator with dead time (000, 3.7.1)."""

from __future__ import annotations

from holonom.control.processes.contract import Rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process, parts_of
from holonom.errors import ModelError
from holonom.registry import Method

__all__ = ["LAG_COMPENSATION"]


def _gains(process: Process, form: str) -> Gains:
    """`L = e^(-s T_H)/(2 s T_H)`: phase margin 90 deg - 1/2 rad = 61.4 deg; `K_c = T/(2 K_p T_H)`, `T_i = T`."""
    parts = parts_of(process)
    if parts.integrators or parts.swings or parts.leads or len(parts.lags) > 1 or parts.dead_time == 0.0:
        raise ModelError("lag compensation takes dead time with one lag, or alone")
    if form == "I":
        if parts.lags:
            raise ModelError("form I is for dead time alone; with a lag take PI, whose zero cancels it")
        return Gains(0.5 / parts.gain, parts.dead_time)
    if not parts.lags:
        raise ModelError("dead time alone has no lag to compensate: take form I")
    return Gains(parts.lags[0] / (2.0 * parts.gain * parts.dead_time), parts.lags[0])


LAG_COMPENSATION = Method(
    "zero on the lag, 61.4 deg from the dead time; one lag with dead time",
    lambda settings: Rule(("I", "PI"), _gains),
    "specification 04.2; integrator with dead time, phase margin 61.4 deg",
)
