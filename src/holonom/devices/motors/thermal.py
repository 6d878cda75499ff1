"""Two bodies, winding and housing: temperatures, duty rating, largest continuous current (spec 03.1).

With the copper's resistance `R(T) = R25 (1 + alpha (T - 25))` both bodies obey

    C_w dT_w/dt = R(T_w) i^2 - (T_w - T_h)/R_th2,      C_h dT_h/dt = (T_w - T_h)/R_th2 - (T_h - T_a)/R_th1,

linear at a constant current, so a step is exact however long. `C_w = tau_w / R_th2`, `C_h = tau_s / R_th1`: the usual
reading of the time constants that maxon prints.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError, OutOfLimits
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["COPPER", "Temperatures", "ThermalModel", "ThermalParams", "thermal_step"]

COPPER = 0.0039
"""Temperature coefficient of copper's resistance at 25 degC, 1/K."""
REFERENCE = 25.0
"""Temperature that a sheet's resistance is meant at, degC."""


class ThermalParams(NamedTuple):
    """R in ohm at 25 degC, R_th1, R_th2 in K/W, C_w, C_h in J/K, ambient in degC, alpha in 1/K."""

    resistance: float
    housing_to_air: float
    winding_to_housing: float
    winding_capacity: float
    housing_capacity: float
    ambient: float
    coefficient: float


class Temperatures(NamedTuple):
    """Winding and housing, degC."""

    winding: float
    housing: float


@loop
def thermal_step(params: ThermalParams, state: Temperatures, current: float, dt: float) -> Temperatures:
    """Temperatures (degC) `dt` s later at a held current (A, rms within the step); exact (03.1)."""
    losses = params.resistance * current * current
    warming = losses * params.coefficient
    through, away = 1.0 / params.winding_to_housing, 1.0 / params.housing_to_air
    a = (warming - through) / params.winding_capacity
    b = through / params.winding_capacity
    c = through / params.housing_capacity
    d = -(through + away) / params.housing_capacity
    winding, housing = state.winding - params.ambient, state.housing - params.ambient
    cold = losses * (1.0 + params.coefficient * (params.ambient - 25.0)) / params.winding_capacity
    rate_w, rate_h = a * winding + b * housing + cold, c * winding + d * housing  # x' at the start
    mean, half = 0.5 * (a + d), math.sqrt(0.25 * (a - d) * (a - d) + b * c)
    fast, slow = mean - half, mean + half  # both real, as b c > 0; slow > 0 is thermal runaway
    over_fast = math.expm1(fast * dt) / fast if fast != 0.0 else dt
    over_slow = math.expm1(slow * dt) / slow if slow != 0.0 else dt
    # x(t) = x + phi(A) x', phi by Sylvester's formula with the integrals of the two exponentials
    slope = (over_slow - over_fast) / (slow - fast)
    base = over_slow - slow * slope
    return Temperatures(
        state.winding + base * rate_w + slope * (a * rate_w + b * rate_h),
        state.housing + base * rate_h + slope * (c * rate_w + d * rate_h),
    )


@dataclass(frozen=True, slots=True)
class ThermalModel:
    """Winding and housing of a motor, as its sheet prints them.

    Copper losses only: iron, friction and commutation are not counted, so a sheet's nominal current, which may count
    them and other limits, need not be `largest_current`. Neither is fitted to the other.

    Raises
    ------
    ModelError
        A field that is not finite and positive; a limit that is not above the ambient.
    """

    resistance: float = parameter(meaning="of the winding at 25 degrees", unit="ohm", above=0.0, example=1.13)
    housing_to_air: float = parameter(meaning="R_th1", unit="K/W", above=0.0, example=4.65)
    winding_to_housing: float = parameter(meaning="R_th2", unit="K/W", above=0.0, example=1.93)
    winding_time: float = parameter(meaning="tau_w", unit="s", above=0.0, example=41.5)
    housing_time: float = parameter(meaning="tau_s", unit="s", above=0.0, example=809.0)
    ambient: float = parameter(25.0, meaning="temperature of the air", unit="degC", least=-60.0, most=120.0)
    limit: float = parameter(155.0, meaning="largest temperature of the winding", unit="degC", most=400.0)
    coefficient: float = parameter(COPPER, meaning="of the winding's resistance", unit="1/K", least=0.0, most=0.02)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        require("ThermalModel", "limit", self.limit, above=self.ambient)

    def params(self) -> ThermalParams:
        """Params of `thermal_step`."""
        return ThermalParams(
            self.resistance,
            self.housing_to_air,
            self.winding_to_housing,
            self.winding_time / self.winding_to_housing,
            self.housing_time / self.housing_to_air,
            self.ambient,
            self.coefficient,
        )

    def cold(self) -> Temperatures:
        """Both bodies as warm as the air."""
        return Temperatures(self.ambient, self.ambient)

    def settled(self, current: float) -> Temperatures:
        """Temperatures (degC) at a current (A, rms) for ever.

        Raises
        ------
        OutOfLimits
            The current heats the copper faster than the housing cools: no temperature is settled (thermal runaway).
        """
        require("ThermalModel.settled", "current", current)
        both = self.housing_to_air + self.winding_to_housing
        losses = self.resistance * current * current
        left = 1.0 - self.coefficient * both * losses
        if left <= 0.0:
            most = math.sqrt(1.0 / (self.coefficient * both * self.resistance))
            raise OutOfLimits(f"{current:g} A never settle: copper heats faster than it cools from {most:.4g} A on")
        power = losses * (1.0 + self.coefficient * (self.ambient - REFERENCE)) / left
        return Temperatures(self.ambient + both * power, self.ambient + self.housing_to_air * power)

    def largest_current(self, limit: float | None = None) -> float:
        """Largest continuous current, A rms, that keeps the winding at `limit` (degC; the sheet's unless given)."""
        limit = self.limit if limit is None else limit
        require("ThermalModel.largest_current", "limit", limit, above=self.ambient)
        both = self.housing_to_air + self.winding_to_housing
        hot = self.resistance * (1.0 + self.coefficient * (limit - REFERENCE))
        return math.sqrt((limit - self.ambient) / (both * hot))

    def time_to(self, current: float, *, start: Temperatures | None = None, limit: float | None = None) -> float:
        """Time, s, after which the winding reaches `limit`; infinite where it never does.

        Parameters
        ----------
        current : A rms.
        start : temperatures at the beginning, degC; cold unless given.
        limit : degC; the sheet's unless given.
        """
        limit = self.limit if limit is None else limit
        require("ThermalModel.time_to", "current", current)
        require("ThermalModel.time_to", "limit", limit, above=self.ambient)
        begin = self.cold() if start is None else start
        if begin.winding >= limit:
            return 0.0
        params = self.params()

        def reached(time: float) -> bool:
            return thermal_step(params, begin, current, time).winding >= limit

        end = self.winding_time
        while not reached(end):
            end *= 1.5
            if end > 100.0 * (self.winding_time + self.housing_time):
                return math.inf
        low = 0.0
        for piece in range(1, 65):  # the first crossing within `end`: a hot winding on a cold housing may cool again
            if reached(end * piece / 64.0):
                low, end = end * (piece - 1) / 64.0, end * piece / 64.0
                break
        return _least(low, end, reached)

    def hottest(self, current: float, on: float, period: float) -> float:
        """Largest winding temperature, degC, of a current (A) that is on for `on` of every `period` s, for ever.

        Infinite where it grows without end.
        """
        require("ThermalModel.hottest", "current", current)
        require("ThermalModel.hottest", "period", period, above=0.0)
        require("ThermalModel.hottest", "on", on, above=0.0, most=period)
        params, zero = self.params(), self.cold()

        def cycle(state: Temperatures) -> Temperatures:
            return thermal_step(params, thermal_step(params, state, 0.0, period - on), current, on)

        # the cycle is affine: x -> M x + c; its fixed point by two unit columns
        base = cycle(zero)
        first = cycle(Temperatures(zero.winding + 1.0, zero.housing))
        second = cycle(Temperatures(zero.winding, zero.housing + 1.0))
        a, c = first.winding - base.winding, first.housing - base.housing
        b, d = second.winding - base.winding, second.housing - base.housing
        determinant = (1.0 - a) * (1.0 - d) - b * c
        if determinant <= 0.0 or a + d >= 2.0:
            return math.inf
        push, pull = base.winding - zero.winding, base.housing - zero.housing
        return zero.winding + ((1.0 - d) * push + b * pull) / determinant

    def duty(self, current: float, period: float) -> float:
        """Duty rating (S3): largest part of a period (s), 0 to 1, that a current (A) may be on, for ever."""
        require("ThermalModel.duty", "period", period, above=0.0)
        if self.hottest(current, period, period) <= self.limit:
            return 1.0
        return _least(0.0, 1.0, lambda part: self.hottest(current, max(part, 1e-12) * period, period) > self.limit)


def _least(low: float, high: float, holds: Callable[[float], bool]) -> float:
    """Where a condition that grows true begins to hold, by bisection."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
