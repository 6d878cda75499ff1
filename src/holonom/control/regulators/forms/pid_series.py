"""PID in series form: `u/e = K_c (1 + s T_i)/(s T_i) (1 + s T_d)/(1 + s T)`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.control.regulators.contract import PidSettings, Regulator
from holonom.control.regulators.forms.pid_parallel import pid_start, pid_step
from holonom.control.regulators.kernels import PidParams, pid_params
from holonom.errors import OutOfLimits
from holonom.registry import Method

__all__ = ["PID_SERIES", "PidGains", "SeriesSettings", "to_parallel", "to_series"]


class PidGains(NamedTuple):
    """Kc, Ti (s), Td (s) of a form."""

    Kc: float
    Ti: float
    Td: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesSettings(PidSettings):
    """Gains of the series form.

    Raises
    ------
    OutOfLimits
        A number outside its range; of `params`: a derivative that the method cannot take without a filter.
    """

    def params(self, dt: float) -> PidParams:
        """Params of `pid_step` at a sample time, s: those of the parallel form with the same transfer function."""
        lead = 1.0 + (self.Td - self.T) / self.Ti
        return pid_params(self, dt, (self.Kc * lead, self.Kc / self.Ti, self.Kc * (self.Td - lead * self.T)))


def to_parallel(Kc: float, Ti: float, Td: float) -> PidGains:
    """Gains of the parallel form of a series one, both without filter.

    Parameters
    ----------
    Kc, Ti, Td : of the series form; times in s.

    Notes
    -----
    `K_c' = K_c (T_i + T_d)/T_i`, `T_i' = T_i + T_d`, `T_d' = T_i T_d/(T_i + T_d)` (Astrom, Hagglund 2006, 3.2).
    """
    if math.isinf(Ti):
        return PidGains(Kc, Ti, Td)
    return PidGains(Kc * (Ti + Td) / Ti, Ti + Td, Ti * Td / (Ti + Td))


def to_series(Kc: float, Ti: float, Td: float) -> PidGains:
    """Gains of the series form of a parallel one, both without filter; the inverse of `to_parallel`.

    Parameters
    ----------
    Kc, Ti, Td : of the parallel form; times in s.

    Raises
    ------
    OutOfLimits
        Ti below 4 Td: its zeros are complex, and no series form has them.
    """
    if math.isinf(Ti):
        return PidGains(Kc, Ti, Td)
    if Ti < 4.0 * Td:
        raise OutOfLimits(
            f"Ti is {Ti!r} s, Td {Td!r} s; a series form needs Ti of at least 4 Td, which is {4.0 * Td!r}"
        )
    part = 0.5 * (1.0 + math.sqrt(1.0 - 4.0 * Td / Ti))
    return PidGains(Kc * part, Ti * part, Td / part)


PID_SERIES = Method(
    "PI times a filtered lead, conditional integration; no recoil",
    lambda settings: Regulator(pid_step, pid_start, settings, recoils=False),
    "Astrom, Hagglund, Advanced PID Control, 2006, ch. 3; specification 04.1",
    SeriesSettings,
)
