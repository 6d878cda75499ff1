"""Ramsete: nonlinear feedback on the pose error of the reference in time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.path_laws.contract import (
    CommandLimits,
    PathLaw,
    along_limit,
    command_limits,
    curvature_limit,
    error_of,
    limited,
    speed_limit,
    turn_acceleration_limit,
    turn_rate_limit,
)
from holonom.registry import Method, check_fields, parameter
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["RAMSETE", "RamseteParams", "RamseteSettings", "ramsete_step"]


class RamseteParams(NamedTuple):
    """b in 1/m^2 and zeta; limits of the command."""

    limits: CommandLimits
    b: float
    zeta: float


@dataclass(frozen=True, slots=True)
class RamseteSettings:
    """Ramsete; equations, stability and limits in `ramsete_step`.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    b: float = parameter(20.0, meaning="how hard errors are corrected", unit="1/m2", above=0.0)
    zeta: float = parameter(0.8, meaning="damping ratio", above=0.0, below=1.0)
    max_speed: float = speed_limit()
    max_acceleration: float = along_limit()
    max_turn_rate: float = turn_rate_limit()
    max_turn_acceleration: float = turn_acceleration_limit()
    max_curvature: float = curvature_limit()

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, dt: float) -> RamseteParams:
        """Params of `ramsete_step` at a sample time, s."""
        return RamseteParams(command_limits(self, dt), self.b, self.zeta)


@loop(error_model="numpy")
def ramsete_step(
    params: RamseteParams, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar,
    memory: Array,
) -> Planar:  # fmt: skip
    """Twist to command; arguments as `PathLaw` says.

    Notes
    -----
    De Luca, Oriolo, Vendittelli, *Control of wheeled mobile robots: an experimental overview*, 2001, eq. 5.12:
    `k = 2 zeta sqrt(w_r^2 + b v_r^2)`, `v = v_r cos e_theta + k e_x`,
    `w = w_r + k e_theta + b v_r (sin e_theta)/e_theta e_y`.

    Stability: globally asymptotic for b > 0 and 0 < zeta < 1 while the reference moves (v_r, w_r bounded with bounded
    derivatives, not both going to zero) and no limit is reached; `V = b/2 (e_x^2 + e_y^2) + e_theta^2/2` falls. At rest
    nothing is corrected.
    """
    error = error_of(now, pose)
    v, w = now[3], now[5]
    s, c = sincos(error.turn)
    sinc = s / error.turn if abs(error.turn) > 1e-6 else 1.0
    k = 2.0 * params.zeta * math.sqrt(w * w + params.b * v * v)
    rate = w + k * error.turn + params.b * v * sinc * error.across
    return limited(params.limits, before, c * v + k * error.along, rate)


RAMSETE = Method(
    "nonlinear feedback on the pose error of the reference in time",
    lambda settings: PathLaw(ramsete_step, settings),
    "De Luca, Oriolo, Vendittelli, Control of wheeled mobile robots: an experimental overview, 2001",
    RamseteSettings,
)
