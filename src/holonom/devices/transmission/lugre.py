"""LuGre friction: bristles that bend before they slip; stick-slip, presliding, Stribeck's curve (spec 03.2)."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.transmission.kernels import LuGreParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["LuGre"]


@dataclass(frozen=True, slots=True)
class LuGre:
    """Friction of a joint or slide, in N m and rad or N and m.

    Raises
    ------
    ModelError
        A field that is not finite and positive (`damping` and `viscous` may be 0); a static friction below Coulomb's.
    """

    stiffness: float = parameter(meaning="sigma_0 of the bristles", unit="N m/rad", above=0.0, example=1e5)
    damping: float = parameter(meaning="sigma_1 of the bristles", unit="N m s/rad", least=0.0, example=316.228)
    viscous: float = parameter(meaning="sigma_2", unit="N m s/rad", least=0.0, example=0.4)
    coulomb: float = parameter(meaning="F_c, at speed", unit="N m", above=0.0, example=1.0)
    static: float = parameter(meaning="F_s, at rest, at least F_c", unit="N m", above=0.0, example=1.5)
    stribeck_speed: float = parameter(meaning="over which F_s falls to F_c", unit="rad/s", above=0.0, example=1e-3)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        require("LuGre", "static", self.static, least=self.coulomb)

    def params(self, dt: float) -> LuGreParams:
        """Params of `lugre_step` for a step of `dt` (s)."""
        require("LuGre.params", "dt", dt, above=0.0)
        return LuGreParams(
            self.stiffness, self.damping, self.viscous, self.coulomb, self.static, self.stribeck_speed, dt
        )
