"""Two lags by Bode: the regulator's zero on the larger one, the gain by the smaller one (000, 3.7.3)."""

from __future__ import annotations

from holonom.control.processes.contract import Rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process, parts_of
from holonom.errors import ModelError
from holonom.registry import Method

__all__ = ["APERIODIC", "PHASE_MARGIN_50", "PHASE_MARGIN_60"]


def _rule(factor: float) -> Rule:
    """`K_c = factor T_1/(K_p T_2)`, `T_i = T_1`: `L = factor/(s T_2 (1 + s T_2))`."""

    def gains(process: Process, form: str) -> Gains:
        del form
        parts = parts_of(process)
        if parts.integrators or parts.swings or parts.leads or len(parts.lags) != 2 or parts.dead_time > 0.0:
            raise ModelError("this rule takes two lags without dead time")
        return Gains(factor * parts.lags[0] / (parts.gain * parts.lags[1]), parts.lags[0])

    return Rule(("PI",), gains)


_SOURCE = "specification 04.2; second-order system of damping 1/(2 sqrt factor)"
PHASE_MARGIN_60 = Method("62.1 deg and 7.0 %: 0.6 T1/T2; two lags", lambda settings: _rule(0.6), _SOURCE)
PHASE_MARGIN_50 = Method("51.8 deg and 16.3 %: T1/T2; two lags", lambda settings: _rule(1.0), _SOURCE)
APERIODIC = Method("76.3 deg and no overshoot: 0.25 T1/T2; two lags", lambda settings: _rule(0.25), _SOURCE)
