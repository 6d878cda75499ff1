"""Oppelt: by the reaction curve, as Ziegler and Nichols with other numbers, and PD."""

from __future__ import annotations

from holonom.control.processes.contract import Rule
from holonom.control.processes.curve import reaction_curve
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.registry import Method

__all__ = ["OPPELT"]

_TABLE = {"P": Gains(1.0), "PI": Gains(0.8, 3.0), "PD": Gains(1.2, Td=0.25), "PID": Gains(1.2, 2.0, 0.42)}


def _gains(process: Process, form: str) -> Gains:
    curve, table = reaction_curve(process), _TABLE[form]
    unit = 1.0 / (curve.slope * curve.dead_time)
    return Gains(table.Kc * unit, table.Ti * curve.dead_time, table.Td * curve.dead_time)


OPPELT = Method(
    "by slope and dead time of the step response",
    lambda settings: Rule(tuple(_TABLE), _gains),
    "Oppelt, Kleines Handbuch technischer Regelvorgaenge, 1964",
)
