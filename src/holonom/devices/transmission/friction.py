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

    A simulated shaft is held at standstill (`stiction`); a controller, which knows a speed but not whether the shaft
    sticks, feeds it forward without the jump (`params`).

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

    def stiction(self, inertia: float, dt: float) -> StictionParams:
        """Params of `stiction_step` for a step of `dt` (s).

        `inertia` (kg m2) is the least that the shaft may have: with half of what would stop it within one step, the
        spring is as stiff as a semi-implicit step bears, and every motion at rest dies away.
        """
        require("Friction.stiction", "inertia", inertia, above=0.0)
        require("Friction.stiction", "dt", dt, above=0.0)
        holds = max(self.coulomb_positive, self.coulomb_negative) > 0.0
        winding = 0.5 * inertia / dt if holds else 0.0
        return StictionParams(self.viscous, self.coulomb_positive, self.coulomb_negative, winding)

    def params(self, smoothing: float) -> FrictionParams:
        """Params of `friction_torque`: the sign as `w / sqrt(w^2 + e^2)`, e the smoothing in rad/s."""
        require("Friction.params", "smoothing", smoothing, above=0.0)
        return FrictionParams(self.viscous, self.coulomb_positive, self.coulomb_negative, smoothing)
