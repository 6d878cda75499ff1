"""Regulated pure pursuit: arcs to a point ahead on the path, slower in curves and before what is ahead."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.path_laws.contract import (
    AHEAD,
    CommandLimits,
    PathLaw,
    along_limit,
    command_limits,
    curvature_limit,
    direction_of,
    error_of,
    nearest,
    speed_limit,
    towards,
    turn_acceleration_limit,
    turn_rate_limit,
)
from holonom.errors import OutOfLimits
from holonom.registry import Method, check_fields, parameter
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["PURE_PURSUIT", "PurePursuitParams", "PurePursuitSettings", "pure_pursuit_step"]


class PurePursuitParams(NamedTuple):
    """Look-ahead: m, s, m, m; gain 1/s; acceleration across, m/s^2; limits of the command."""

    limits: CommandLimits
    least: float
    time: float
    most: float
    position_gain: float
    max_lateral: float


@dataclass(frozen=True, slots=True)
class PurePursuitSettings:
    """Regulated pure pursuit; equations, stability and limits in `pure_pursuit_step`.

    Raises
    ------
    OutOfLimits
        A number outside its range; a shortest look-ahead above the longest.
    """

    min_look_ahead: float = parameter(0.15, meaning="shortest distance of the point ahead", unit="m", above=0.0)
    look_ahead_time: float = parameter(0.25, meaning="by which it grows with the speed", unit="s", least=0.0)
    max_look_ahead: float = parameter(1.5, meaning="longest distance of the point ahead", unit="m", above=0.0)
    position_gain: float = parameter(2.0, meaning="speed per error along the way", unit="1/s", least=0.0)
    max_lateral: float = parameter(
        2.0, meaning="acceleration across, by which curves cut the speed", unit="m/s2", above=0.0, most=inf
    )
    max_speed: float = speed_limit()
    max_acceleration: float = along_limit()
    max_turn_rate: float = turn_rate_limit()
    max_turn_acceleration: float = turn_acceleration_limit()
    max_curvature: float = curvature_limit()

    def __post_init__(self) -> None:
        check_fields(self)
        if self.min_look_ahead > self.max_look_ahead:
            raise OutOfLimits(
                f"PurePursuitSettings: min_look_ahead is {self.min_look_ahead} m; it must be at most max_look_ahead, "
                f"{self.max_look_ahead} m"
            )

    def params(self, dt: float) -> PurePursuitParams:
        """Params of `pure_pursuit_step` at a sample time, s."""
        return PurePursuitParams(
            command_limits(self, dt),
            self.min_look_ahead,
            self.look_ahead_time,
            self.max_look_ahead,
            self.position_gain,
            self.max_lateral,
        )


@loop(error_model="numpy")
def pure_pursuit_step(
    params: PurePursuitParams, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar,
    memory: Array,
) -> Planar:  # fmt: skip
    """Twist to command; arguments as `PathLaw` says; `memory[AHEAD]` (`nearness`) cuts the speed.

    Notes
    -----
    Coulter, *Implementation of the pure pursuit path tracking algorithm*, CMU-RI-TR-92-01: the arc through the point
    at the look-ahead distance `l = l_0 + t |v|`, which lies aside by y in the robot's axes, has the curvature
    `kappa = 2 y/l^2`. Regulated as Macenski, Singh, Martin, Gines, *Regulated pure pursuit*, Autonomous Robots 2023:
    the speed of the reference in time, `v_r cos e_theta + k_x e_x`, is cut to `sqrt(a/|kappa|)` and by the part that
    what is ahead leaves. Beyond a cusp or the end the path is taken as going on straight.

    Stability: on a straight line `e_y'' + 2 v/l e_y' + 2 v^2/l^2 e_y = 0`, damping ratio 1/sqrt 2 at every speed; a
    steering lag T needs `l > v T` (Ollero & Heredia, IROS 1995). In a curve of radius R it cuts in by about
    `l^2/(2 R)` before it is back on the circle, and where curvature changes; errors shrink with l.
    """
    way = direction_of(path, phase, memory)
    speed = abs(twist.x)
    reach = min(params.least + params.time * speed, params.most)
    k = nearest(path, phase, way, pose.x, pose.y, 0.0, memory)
    last = path.shape[0] - 1
    j, square = k, reach * reach
    dx, dy = path[j, 0] - pose.x, path[j, 1] - pose.y
    while dx * dx + dy * dy < square and j < last and path[j + 1, 3] * way >= 0.0:
        j += 1
        dx, dy = path[j, 0] - pose.x, path[j, 1] - pose.y
    if dx * dx + dy * dy < square:  # the end: straight on to the circle around the robot
        t, r = sincos(path[j, 2])
        along = way * (r * dx + t * dy)
        on = math.sqrt(along * along + square - dx * dx - dy * dy) - along
        dx += way * on * r
        dy += way * on * t
    s, c = sincos(pose.turn)
    curvature = way * 2.0 * (c * dy - s * dx) / (dx * dx + dy * dy)
    error = error_of(now, pose)
    _, d = sincos(error.turn)
    wanted = max(way * (d * now[3] + params.position_gain * error.along), 0.0)
    wanted = min(wanted, math.sqrt(params.max_lateral / max(abs(curvature), 1e-9)))
    return towards(params.limits, before, way, wanted * (1.0 - memory[AHEAD]), curvature)


PURE_PURSUIT = Method(
    "arcs to a point ahead; slower in curves and before what is ahead",
    lambda settings: PathLaw(pure_pursuit_step, settings),
    "Coulter, CMU-RI-TR-92-01; Macenski et al., Regulated pure pursuit, Autonomous Robots 2023",
    PurePursuitSettings,
)
