"""Friction of a motor or joint shaft: viscous plus asymmetric Coulomb, which holds at standstill."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.transmission.kernels import FrictionParams, StictionParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Friction"]


@dataclass(frozen=True, slots=True)
class Friction:
    """Friction as `B w + T_c`, two magnitudes for the two directions.

    Towards rest, T_c grows by Stribeck's curve: times `1 + (r - 1) / (1 + (w / w_s)^2)` (Hess & Soom 1990), the static
    ratio r at rest.

    A simulated shaft is held at standstill (`stiction`); a controller, which knows a speed but not whether the shaft
    sticks, feeds it forward without the jump (`params`).

    Tables often print the magnitude for negative speed as a negative number.

    Raises
    ------
    ModelError
        A field that is negative or not finite, a static ratio below 1 or without its speed.
    """

    viscous: float = parameter(0.0, meaning="B", unit="N m s/rad", least=0.0)
    coulomb_positive: float = parameter(0.0, meaning="magnitude of T_c for positive speed", unit="N m", least=0.0)
    coulomb_negative: float = parameter(0.0, meaning="magnitude of T_c for negative speed", unit="N m", least=0.0)
    static_ratio: float = parameter(1.0, meaning="r, T_c at rest over T_c at speed", least=1.0)
    stribeck_speed: float = parameter(0.0, meaning="w_s at which half of the rise is left", unit="rad/s", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.static_ratio > 1.0 and self.stribeck_speed == 0.0:
            raise ModelError(
                f"Friction: static_ratio is {self.static_ratio:g}, stribeck_speed 0; state the speed (rad/s) at "
                "which half of the rise is left, or a ratio of 1"
            )

    @property
    def rise(self) -> float:
        """By which part of Coulomb friction that at rest is greater."""
        return self.static_ratio - 1.0

    @property
    def per_stribeck(self) -> float:
        """The inverse of the Stribeck speed, s/rad; 0 where friction at rest is no greater."""
        return 1.0 / self.stribeck_speed if self.rise > 0.0 else 0.0

    def stiction(self, inertia: float, dt: float, efficiency: float = 1.0) -> StictionParams:
        """Params of `stiction_step` for a step of `dt` (s).

        `inertia` (kg m2) is the least that the shaft may have: with half of what would stop it within one step, the
        spring is as stiff as a semi-implicit step bears, and every motion at rest dies away. `efficiency` is that of
        the gear behind it, for `geared_step`.
        """
        require("Friction.stiction", "inertia", inertia, above=0.0)
        require("Friction.stiction", "dt", dt, above=0.0)
        require("Friction.stiction", "efficiency", efficiency, above=0.0, most=1.0)
        holds = max(self.coulomb_positive, self.coulomb_negative) > 0.0 or efficiency < 1.0
        winding = 0.5 * inertia / dt if holds else 0.0
        return StictionParams(
            self.viscous, self.coulomb_positive, self.coulomb_negative, winding, self.rise, self.per_stribeck
        )

    def params(self, smoothing: float) -> FrictionParams:
        """Params of `friction_torque`: the sign as `w / sqrt(w^2 + e^2)`, e the smoothing in rad/s."""
        require("Friction.params", "smoothing", smoothing, above=0.0)
        return FrictionParams(
            self.viscous, self.coulomb_positive, self.coulomb_negative, smoothing, self.rise, self.per_stribeck
        )
