"""Integrating process with a lag: the crossover in the middle between the regulator's zero and the lag (000, 3.7.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.processes.contract import Rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process, parts_of
from holonom.errors import ModelError
from holonom.registry import Method, check_fields, parameter

__all__ = ["SYMMETRICAL_BODE", "SymmetricalSettings", "small_lag"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SymmetricalSettings:
    """How far zero and lag are apart.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    ratio: float = parameter(10.0, meaning="Ti over the lag", above=1.0, most=1e6)

    def __post_init__(self) -> None:
        check_fields(self)


def small_lag(process: Process) -> tuple[float, float]:
    """Rate per input (1/s) of an integrating process, and its lags and dead time together, s.

    Raises
    ------
    ModelError
        Not one integrator with a lag or dead time.
    """
    parts = parts_of(process)
    small = sum(parts.lags) + parts.dead_time
    if parts.integrators != 1 or parts.swings or parts.leads or small <= 0.0:
        raise ModelError("this rule takes one integrator with a lag, or with dead time")
    return parts.gain, small


def _rule(settings: SymmetricalSettings) -> Rule:
    """`T_i = a T`, `w_c = 1/(T sqrt a)`, `K_c = w_c/K`: phase margin `atan sqrt a - atan 1/sqrt a`."""

    def gains(process: Process, form: str) -> Gains:
        del form
        rate, lag = small_lag(process)
        return Gains(1.0 / (lag * math.sqrt(settings.ratio) * rate), settings.ratio * lag)

    return Rule(("PI",), gains, prefilter=True)


SYMMETRICAL_BODE = Method(
    "crossover halfway between zero and lag, 54.9 deg at ratio 10; integrator with a lag",
    _rule,
    "specification 04.2",
    SymmetricalSettings,
)
