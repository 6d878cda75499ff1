"""LTV law: linear quadratic regulator of the pose error, its gains over the speed of the reference."""

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

__all__ = ["LTV", "LtvParams", "LtvSettings", "ltv_gains", "ltv_step"]

SLOW = 0.1  # m/s, below which the gain across fades: at rest the error across cannot be controlled


class LtvParams(NamedTuple):
    """Weight ratios of the regulator: 1/s, 1/(m s), 1/s^2; limits of the command."""

    limits: CommandLimits
    along: float
    across: float
    turn: float


@dataclass(frozen=True, slots=True)
class LtvSettings:
    """LTV law: Bryson's weights; equations, stability and limits in `ltv_step`.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    error_along: float = parameter(0.15, meaning="error that weighs as much as `effort_speed`", unit="m", above=0.0)
    error_across: float = parameter(0.06, meaning="error that weighs as much as `effort_turn`", unit="m", above=0.0)
    error_heading: float = parameter(
        0.5, meaning="heading error that weighs as much as `effort_turn`", unit="rad", above=0.0
    )
    effort_speed: float = parameter(0.5, meaning="correction of the speed", unit="m/s", above=0.0)
    effort_turn: float = parameter(1.5, meaning="correction of the turning rate", unit="rad/s", above=0.0)
    max_speed: float = speed_limit()
    max_acceleration: float = along_limit()
    max_turn_rate: float = turn_rate_limit()
    max_turn_acceleration: float = turn_acceleration_limit()
    max_curvature: float = curvature_limit()

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, dt: float) -> LtvParams:
        """Params of `ltv_step` at a sample time, s."""
        return LtvParams(
            command_limits(self, dt),
            self.effort_speed / self.error_along,
            self.effort_turn / self.error_across,
            (self.effort_turn / self.error_heading) ** 2,
        )


@loop(error_model="numpy")
def ltv_gains(params: LtvParams, speed: float) -> tuple[float, float, float]:
    """Gains (k_x, k_y, k_theta) at a speed of the reference, m/s: the algebraic Riccati equation, solved by hand.

    Of `e_y' = v e_theta, e_theta' = -u` with weights q_y, q_theta, r: `k_y = sgn(v) sqrt(q_y/r)`,
    `k_theta = sqrt(q_theta/r + 2 |v| |k_y|)`.
    """
    across = params.across * speed / max(abs(speed), SLOW)
    return params.along, across, math.sqrt(params.turn + 2.0 * speed * across)


@loop(error_model="numpy")
def ltv_step(
    params: LtvParams, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar,
    memory: Array,
) -> Planar:  # fmt: skip
    """Twist to command; arguments as `PathLaw` says.

    Notes
    -----
    `v = v_r cos e_theta + k_x e_x`, `w = w_r + k_y e_y + k_theta e_theta`: the regulator of the errors linearised about
    the reference (Corke, *Robotics, Vision and Control*, 4.1; Anderson & Moore, *Optimal Control*, 2.3), with the gains
    of the present speed (`ltv_gains`); what turning mixes into the errors, `w_r`, is left out of them.

    Stability: the linearised error is asymptotically stable at every constant v_r other than 0, also with w_r
    (`V = k_y/v_r (e_x^2 + e_y^2)/2 + e_theta^2/2` falls), with a phase margin of at least 60 degrees; v_r that changes
    must do so slowly beside `1/k_x` and `1/k_theta`. Below 0.1 m/s the gain across fades. Linear in the heading error:
    for errors below a radian.
    """
    error = error_of(now, pose)
    along, across, turn = ltv_gains(params, now[3])
    _, d = sincos(error.turn)
    speed = d * now[3] + along * error.along
    return limited(params.limits, before, speed, now[5] + across * error.across + turn * error.turn)


LTV = Method(
    "linear quadratic regulator of the pose error, gains over the speed",
    lambda settings: PathLaw(ltv_step, settings),
    "Anderson & Moore, Optimal Control: Linear Quadratic Methods, 2.3; Corke, Robotics, Vision and Control, 4.1",
    LtvSettings,
)
