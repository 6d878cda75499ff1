"""Ziegler and Nichols: by the reaction curve, and by the ultimate gain."""

from __future__ import annotations

from holonom.control.processes.contract import Rule
from holonom.control.processes.curve import reaction_curve
from holonom.control.processes.loop import Gains, ultimate_gain
from holonom.control.processes.process import Process
from holonom.registry import Method

__all__ = ["ZIEGLER_NICHOLS", "ZIEGLER_NICHOLS_ULTIMATE"]

_CURVE = {"P": Gains(1.0), "PI": Gains(0.9, 3.3), "PID": Gains(1.2, 2.0, 0.5)}
_ULTIMATE = {"P": Gains(0.5), "PI": Gains(0.45, 1.0 / 1.2), "PID": Gains(0.6, 0.5, 0.125)}


def _by_curve(process: Process, form: str) -> Gains:
    curve, table = reaction_curve(process), _CURVE[form]
    unit = 1.0 / (curve.slope * curve.dead_time)
    return Gains(table.Kc * unit, table.Ti * curve.dead_time, table.Td * curve.dead_time)


def _by_swinging(process: Process, form: str) -> Gains:
    (Ku, Tu), table = ultimate_gain(process), _ULTIMATE[form]
    return Gains(table.Kc * Ku, table.Ti * Tu, table.Td * Tu)


_SOURCE = "Ziegler, Nichols, Trans. ASME 64, 1942, 759"
ZIEGLER_NICHOLS = Method(
    "by slope and dead time of the step response; quarter-decay",
    lambda settings: Rule(tuple(_CURVE), _by_curve),
    _SOURCE,
)
ZIEGLER_NICHOLS_ULTIMATE = Method(
    "by the gain at which it swings; quarter-decay", lambda settings: Rule(tuple(_ULTIMATE), _by_swinging), _SOURCE
)
