"""Lambda tuning: the closed loop as a lag of a given time behind the dead time."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.control.processes.contract import Rule
from holonom.control.processes.curve import Curve, half_rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.errors import ModelError
from holonom.registry import Method, check_fields, parameter

__all__ = ["LAMBDA", "LambdaSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LambdaSettings:
    """How fast.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    closed_lag: float | None = parameter(
        None, meaning="lambda, lag of the closed loop; none: the process's lag, integrating: three dead times",
        unit="s", least=1e-9, most=1e9,
    )  # fmt: skip

    def __post_init__(self) -> None:
        check_fields(self)


def _rule(settings: LambdaSettings) -> Rule:
    """PI: `K_c = T/(K (lambda + theta))`, `T_i = T`, integrating `2 lambda + theta`; PID by internal model control."""

    def gains(process: Process, form: str) -> Gains:
        model = half_rule(process, 1)
        T, theta = model.lag, model.dead_time
        wanted = settings.closed_lag
        if form == "P":
            return _proportional(model, wanted)
        if math.isinf(T):
            slow = 3.0 * theta if wanted is None else wanted
            if form != "PI" or slow <= 0.0:
                raise ModelError("an integrating process: lambda tuning has PI, and needs dead time or closed_lag")
            return Gains((2.0 * slow + theta) / (model.slope * (slow + theta) ** 2), 2.0 * slow + theta)
        if T == 0.0:
            raise ModelError("dead time alone: lambda tuning gives an integral alone; take form I")
        slow = T if wanted is None else wanted
        if form == "PI":
            return Gains(T / (model.gain * (slow + theta)), T)
        if theta == 0.0:
            raise ModelError("without dead time lambda tuning has no derivative; take PI")
        half = 0.5 * theta
        return Gains((T + half) / (model.gain * (slow + half)), T + half, T * half / (T + half))

    return Rule(("P", "PI", "PID"), gains)


def _proportional(model: Curve, wanted: float | None) -> Gains:
    """`K_c = (T/lambda - 1)/K`, integrating `1/(K lambda)`: without dead time any lag can be had."""
    if model.dead_time > 0.0 or model.lag == 0.0 or wanted is None or not wanted < model.lag:
        raise ModelError("P by lambda takes one lag, or an integrator, and closed_lag, which is less than that lag")
    if math.isinf(model.lag):
        return Gains(1.0 / (model.slope * wanted))
    return Gains((model.lag / wanted - 1.0) / model.gain)


LAMBDA = Method(
    "closed loop a lag of a given time; real lags, integrator, dead time",
    _rule,
    "Dahlin, Instruments and Control Systems 41, 1968; Rivera, Morari, Skogestad, Ind. Eng. Chem. 25, 1986",
    LambdaSettings,
)
