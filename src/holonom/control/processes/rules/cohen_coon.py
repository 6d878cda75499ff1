"""Cohen and Coon: by the reaction curve, with its dead time over the whole."""

from __future__ import annotations

import math

from holonom.control.processes.contract import Rule
from holonom.control.processes.curve import reaction_curve
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.registry import Method

__all__ = ["COHEN_COON"]


def _gains(process: Process, form: str) -> Gains:
    """`a = K L/T`, `tau = L/(L + T)` (Astrom, Hagglund, PID Controllers, 1995, 4.2)."""
    curve = reaction_curve(process)
    L, unit = curve.dead_time, 1.0 / (curve.slope * curve.dead_time)
    tau = 0.0 if math.isinf(curve.lag) else L / (L + curve.lag)
    more = tau / (1.0 - tau)
    if form == "P":
        return Gains(unit * (1.0 + 0.35 * more))
    if form == "PI":
        return Gains(0.9 * unit * (1.0 + 0.92 * more), (3.3 - 3.0 * tau) / (1.0 + 1.2 * tau) * L)
    if form == "PD":
        return Gains(1.24 * unit * (1.0 + 0.13 * more), Td=(0.27 - 0.36 * tau) / (1.0 - 0.87 * tau) * L)
    Ti = (2.5 - 2.0 * tau) / (1.0 - 0.39 * tau) * L
    return Gains(1.35 * unit * (1.0 + 0.18 * more), Ti, (0.37 - 0.37 * tau) / (1.0 - 0.81 * tau) * L)


COHEN_COON = Method(
    "quarter-decay with much dead time, by the step response",
    lambda settings: Rule(("P", "PI", "PD", "PID"), _gains),
    "Cohen, Coon, Trans. ASME 75, 1953, 827",
)
