"""Symmetrical optimum: an integrating process with a small lag, Ti four times that lag."""

from __future__ import annotations

from holonom.control.processes.contract import Rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.control.processes.rules.symmetrical_bode import small_lag
from holonom.registry import Method

__all__ = ["SYMMETRICAL_OPTIMUM"]


def _gains(process: Process, form: str) -> Gains:
    """`T_i = 4 T_s`, `K_c = 1/(2 K T_s)`: phase margin 36.9 deg; the reference wants a prefilter of Ti."""
    del form
    rate, lag = small_lag(process)
    return Gains(1.0 / (2.0 * rate * lag), 4.0 * lag)


SYMMETRICAL_OPTIMUM = Method(
    "Ti four lags, 43.4 % (8.1 % with prefilter), quick after loads; integrator with a lag",
    lambda settings: Rule(("PI",), _gains, prefilter=True),
    "Kessler, Regelungstechnik 6, 1958",
)
