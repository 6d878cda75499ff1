"""PID with two degrees of freedom: the reference enters by weights, the measurement whole."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.control.regulators.contract import Regulator
from holonom.control.regulators.forms.pid_parallel import ParallelSettings, pid_start, pid_step
from holonom.control.regulators.kernels import PidParams, pid_params
from holonom.registry import Method, parameter

__all__ = ["PID_TWO_DOF", "TwoDofSettings"]


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoDofSettings(ParallelSettings):
    """Gains of the form `u = K_c (b r - y + (r - y)/(s T_i) + s T_d (c r - y)/(1 + s T))`.

    Raises
    ------
    OutOfLimits
        A number outside its range; of `params`: a derivative that the method cannot take without a filter.
    """

    b: float = parameter(1.0, meaning="weight of the reference in the proportional part", least=0.0)
    c: float = parameter(0.0, meaning="weight of the reference in the derivative", least=0.0)

    def params(self, dt: float) -> PidParams:
        """Params of `pid_step` at a sample time, s."""
        gains = (self.Kc, self.Kc / self.Ti, self.Kc * self.Td)
        return pid_params(self, dt, gains, b=self.b, c=self.c, four=self.four_samples)


PID_TWO_DOF = Method(
    "parallel PID, reference weighted by b and c, derivative of the measurement unless told; no recoil",
    lambda settings: Regulator(pid_step, pid_start, settings, recoils=False),
    "Astrom, Hagglund, Advanced PID Control, 2006, 3.4; specification 04.1",
    TwoDofSettings,
)
