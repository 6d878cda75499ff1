"""Table of regulators."""

from __future__ import annotations

from holonom.registry import Table

__all__ = ["REGULATORS"]

_HERE = "holonom.control.regulators.forms"

REGULATORS = Table(
    "regulators",
    "regulator",
    "a `Regulator`: its compiled step and start, its settings, and whether it recoils",
    {
        "on_off_2": f"{_HERE}.on_off:TWO_POSITIONS",
        "on_off_3": f"{_HERE}.on_off:THREE_POSITIONS",
        "on_off_5": f"{_HERE}.on_off:FIVE_POSITIONS",
        "time_proportional": f"{_HERE}.time_proportional:TIME_PROPORTIONAL",
        "pid_parallel": f"{_HERE}.pid_parallel:PID_PARALLEL",
        "pid_series": f"{_HERE}.pid_series:PID_SERIES",
        "pid_two_dof": f"{_HERE}.pid_two_dof:PID_TWO_DOF",
        "incremental": f"{_HERE}.incremental:INCREMENTAL",
        "recursive": f"{_HERE}.recursive:RECURSIVE",
        "reset": f"{_HERE}.reset:RESET",
        "foxboro": f"{_HERE}.foxboro:FOXBORO",
        "conditional": f"{_HERE}.conditional:CONDITIONAL",
        "back_calculation": f"{_HERE}.back_calculation:BACK_CALCULATION",
    },
)
