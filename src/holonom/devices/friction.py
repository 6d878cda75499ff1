"""Friction of a motor or joint shaft: viscous plus asymmetric Coulomb, made smooth at standstill."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.kernels import FrictionParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Friction"]


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction as `B w + T_c(sign w) w / sqrt(w^2 + e^2)`.

    The sign is regularised, so standstill is approximate: below the breakaway torque the shaft does not
    stick, it creeps at `w = e T / sqrt(T_c^2 - T^2)`.

    Tables often print the magnitude for negative speed as a negative number.

    Raises
    ------
    ModelError
        A field that is negative or not finite.
    """

    viscous: float = parameter(0.0, meaning="B", unit="N m s/rad", least=0.0)
    coulomb_positive: float = parameter(0.0, meaning="magnitude of T_c for positive speed", unit="N m", least=0.0)
    coulomb_negative: float = parameter(0.0, meaning="magnitude of T_c for negative speed", unit="N m", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def smallest_smoothing(self, inertia: float, dt: float) -> float:
        """Least smoothing e (rad/s) with which an explicit step does not chatter about standstill: `T_c dt / J`.

        There one step of `dt` (s) takes a small speed of the inertia J (kg m^2) just to zero; beyond half of
        it the step would overshoot by more than it began with.
        """
        return max(self.coulomb_positive, self.coulomb_negative) * dt / inertia

    def params(self, smoothing: float) -> FrictionParams:
        """Params of `friction_torque` with a smoothing in rad/s, not below `smallest_smoothing`."""
        require("Friction.params", "smoothing", smoothing, above=0.0)
        return FrictionParams(self.viscous, self.coulomb_positive, self.coulomb_negative, smoothing)
