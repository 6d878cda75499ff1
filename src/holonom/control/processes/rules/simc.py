"""SIMC: one lag or two by the half rule, the closed loop as fast as its dead time."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.processes.contract import Rule
from holonom.control.processes.curve import half_rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.errors import ModelError
from holonom.registry import Method, check_fields, parameter

__all__ = ["SIMC", "SimcSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SimcSettings:
    """How fast.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    tau_c: float | None = parameter(
        None, meaning="lag of the closed loop; none: the dead time", unit="s", least=1e-9, most=1e9
    )

    def __post_init__(self) -> None:
        check_fields(self)


def _rule(settings: SimcSettings) -> Rule:
    """`K_c = T/(K (tau_c + theta))`, `T_i = min(T, 4 (tau_c + theta))`; PID: a PD of the second lag before it."""

    def gains(process: Process, form: str) -> Gains:
        model = half_rule(process, 2 if form == "PID" else 1)
        tau = model.dead_time if settings.tau_c is None else settings.tau_c
        both = tau + model.dead_time
        if both <= 0.0:
            raise ModelError("what the half rule leaves has no dead time; give tau_c, the lag of the closed loop")
        if model.lag == 0.0:
            raise ModelError("dead time alone: SIMC gives an integral alone, Kc = 0; take form I")
        Kc, Ti = 1.0 / (model.slope * both), min(model.lag, 4.0 * both)
        if form == "PI":
            return Gains(Kc, Ti)
        if model.second == 0.0:
            raise ModelError("PID needs a second lag; without one take PI")
        Td = model.second
        return Gains(Kc * (Ti + Td) / Ti, Ti + Td, Ti * Td / (Ti + Td))

    return Rule(("PI", "PID"), gains)


SIMC = Method(
    "half rule, closed loop as fast as the dead time; real lags, integrator, dead time",
    _rule,
    "Skogestad, J. Process Control 13, 2003, 291",
    SimcSettings,
)
