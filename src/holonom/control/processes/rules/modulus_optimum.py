"""Modulus optimum: zeros on the largest lags, the rest counts as one small lag."""

from __future__ import annotations

from holonom.control.processes.contract import Rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process, parts_of
from holonom.errors import ModelError
from holonom.registry import Method

__all__ = ["MODULUS_OPTIMUM"]


def _gains(process: Process, form: str) -> Gains:
    """`L = 1/(2 s T_s (1 + s T_s))`, damping 1/sqrt 2; PID as a product of PI and PD, then in parallel form."""
    parts = parts_of(process)
    count = 1 if form == "PI" else 2
    small = sum(parts.lags[count:]) + parts.dead_time
    if parts.integrators or parts.swings or parts.leads or len(parts.lags) < count or small <= 0.0:
        raise ModelError(
            f"the modulus optimum with {form} takes {count} lag{'s' * (count - 1)} and a smaller lag or dead time"
        )
    T1 = parts.lags[0]
    gain = T1 / (2.0 * parts.gain * small)
    if form == "PI":
        return Gains(gain, T1)
    T2 = parts.lags[1]
    return Gains(gain * (T1 + T2) / T1, T1 + T2, T1 * T2 / (T1 + T2))


MODULUS_OPTIMUM = Method(
    "largest lags cancelled, damping 0.71 by the rest; lags",
    lambda settings: Rule(("PI", "PID"), _gains),
    "Kessler, Regelungstechnik 3, 1955; overshoot 4.3 %",
)
