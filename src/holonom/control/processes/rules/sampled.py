"""By the sampled process: the largest gain that keeps a phase margin with hold and computing delay."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.processes.contract import Rule
from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process, parts_of
from holonom.control.processes.sampled import largest_gain
from holonom.errors import ModelError
from holonom.registry import Method, check_fields, parameter

__all__ = ["SAMPLED", "SampledSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SampledSettings:
    """The sampled loop.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    sample_time: float = parameter(meaning="of the regulator", unit="s", least=1e-9, most=1e9, example=0.1)
    delay_samples: int = parameter(1, meaning="for computing", least=0, most=100)
    margin_deg: float = parameter(60.0, meaning="phase margin to keep", unit="deg", above=0.0, below=90.0)
    ratio: float = parameter(20.0, meaning="Ti over the other lags and delays; integrating", above=1.0, most=1e6)

    def __post_init__(self) -> None:
        check_fields(self)


def _rule(settings: SampledSettings) -> Rule:
    """Ti is the largest lag; of an integrating process `ratio` times all that delays, half of a sample included."""

    def gains(process: Process, form: str) -> Gains:
        parts = parts_of(process)
        if len(process.den) == 1:
            raise ModelError("this rule takes a process with a lag or an integrator")
        if form == "PI" and not (parts.integrators or parts.lags):
            raise ModelError("this rule takes PI on a process with a real lag or an integrator")
        if form == "P":
            shape = Gains(1.0)
        elif parts.integrators:
            delays = sum(parts.lags) + parts.dead_time + (settings.delay_samples + 0.5) * settings.sample_time
            shape = Gains(1.0, settings.ratio * delays)
        else:
            shape = Gains(1.0, parts.lags[0])
        dt, delay, margin = settings.sample_time, settings.delay_samples, settings.margin_deg
        return shape._replace(Kc=largest_gain(process, shape, dt, delay_samples=delay, margin_deg=margin))

    return Rule(("P", "PI"), gains)


SAMPLED = Method(
    "largest gain that keeps a phase margin with sampling and computing; lags, integrator, dead time",
    _rule,
    "Franklin, Powell, Workman, Digital Control of Dynamic Systems, ch. 7; specification 04.5",
    SampledSettings,
)
