"""Chien, Hrones and Reswick: for loads or references, without overshoot or with 20 %."""

from __future__ import annotations

import math
from collections.abc import Mapping

from holonom.control.processes.contract import Rule
from holonom.control.processes.curve import reaction_curve
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.errors import ModelError
from holonom.registry import Method

__all__ = ["CHR_DISTURBANCE_0", "CHR_DISTURBANCE_20", "CHR_SETPOINT_0", "CHR_SETPOINT_20"]


def _rule(table: Mapping[str, Gains], by_lag: bool) -> Rule:
    """Kc in units of T/(K L), Ti of the dead time L or of the lag T, Td of L."""

    def gains(process: Process, form: str) -> Gains:
        curve, row = reaction_curve(process), table[form]
        if by_lag and math.isinf(curve.lag):
            raise ModelError("an integrating process has no lag; take chr_disturbance_0 or chr_disturbance_20")
        unit = curve.lag if by_lag else curve.dead_time
        return Gains(row.Kc / (curve.slope * curve.dead_time), row.Ti * unit, row.Td * curve.dead_time)

    return Rule(tuple(table), gains)


_SOURCE = "Chien, Hrones, Reswick, Trans. ASME 74, 1952, 175"
CHR_DISTURBANCE_0 = Method(
    "load without overshoot, by the step response",
    lambda settings: _rule({"P": Gains(0.3), "PI": Gains(0.6, 4.0), "PID": Gains(0.95, 2.4, 0.42)}, False),
    _SOURCE,
)
CHR_DISTURBANCE_20 = Method(
    "load with 20 % overshoot, by the step response",
    lambda settings: _rule({"P": Gains(0.7), "PI": Gains(0.7, 2.3), "PID": Gains(1.2, 2.0, 0.42)}, False),
    _SOURCE,
)
CHR_SETPOINT_0 = Method(
    "reference without overshoot, by the step response",
    lambda settings: _rule({"P": Gains(0.3), "PI": Gains(0.35, 1.2), "PID": Gains(0.6, 1.0, 0.5)}, True),
    _SOURCE,
)
CHR_SETPOINT_20 = Method(
    "reference with 20 % overshoot, by the step response",
    lambda settings: _rule({"P": Gains(0.7), "PI": Gains(0.6, 1.0), "PID": Gains(0.95, 1.4, 0.47)}, True),
    _SOURCE,
)
