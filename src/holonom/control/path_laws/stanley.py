"""Stanley: the leading axle is steered onto the path, by heading error and cross-track error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.path_laws.contract import (
    CommandLimits,
    LawSettings,
    PathLaw,
    curvature_at,
    direction_of,
    error_of,
    nearest,
    towards,
)
from holonom.registry import Method, parameter
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["STANLEY", "StanleyParams", "StanleySettings", "stanley_step"]

LEAD = 0.3  # m, of a leading axle that nobody states
STEEPEST = math.radians(80.0)  # steering angle of the leading axle, where the base may turn on the spot


class StanleyParams(NamedTuple):
    """Gains in 1/s, softening speed, distance of the leading axle; limits of the command."""

    limits: CommandLimits
    gain: float
    softening: float
    lead: float
    position_gain: float


@dataclass(frozen=True, slots=True, kw_only=True)
class StanleySettings(LawSettings):
    """Stanley's law; equations, stability and limits in `stanley_step`.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    gain: float = parameter(3.0, meaning="k: the cross-track error's", unit="1/s", above=0.0)
    softening: float = parameter(0.2, meaning="added to the speed, so that it does not steer hard at rest",
                                 unit="m/s", above=0.0)  # fmt: skip
    lead: float | None = parameter(
        None, meaning="of the leading axle before base_link: a car's wheelbase; None: the base's, else 0.3 m",
        unit="m", above=0.0,
    )  # fmt: skip
    position_gain: float = parameter(2.0, meaning="speed per error along the way", unit="1/s", least=0.0)

    def params(self, dt: float) -> StanleyParams:
        """Params of `stanley_step` at a sample time, s."""
        return StanleyParams(self.limits(dt), self.gain, self.softening, self.lead or LEAD, self.position_gain)


@loop(error_model="numpy")
def stanley_step(
    params: StanleyParams, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar,
    memory: Array,
) -> Planar:  # fmt: skip
    """Twist to command; arguments as `PathLaw` says.

    Notes
    -----
    Hoffmann, Tomlin, Montemerlo, Thrun, *Autonomous automobile trajectory tracking for off-road driving*, ACC 2007:
    `delta = psi + atan(k e/(k_s + |v|))`, with e the distance of the leading axle from its path, psi the angle from
    the robot's heading to that path; `w = v tan(delta)/L`. The path of the axle is the one that it takes on the given
    path, so that curves are kept without an offset. Backwards the same point lies behind: what leads is mirrored.
    The speed is that of the reference in time, `v = v_r cos e_theta + k_x e_x`, never against the way.

    Stability: e falls exponentially with k (small e, high speed) for every k > 0 and |psi| < pi/2 while the steering is
    not at its limit; at a sample time or steering lag T, k T must be well below 1.
    """
    way = direction_of(path, phase, memory)
    s, c = sincos(pose.turn)
    x, y = pose.x + way * params.lead * c, pose.y + way * params.lead * s
    k = nearest(path, phase, way, x, y, params.lead, memory)
    lean = math.atan(params.lead * curvature_at(path, k, way))
    e, d = sincos(path[k, 2] + lean)
    t, r = sincos(path[k, 2])
    px = path[k, 0] - pose.x + way * params.lead * (r - c)
    py = path[k, 1] - pose.y + way * params.lead * (t - s)
    aside = way * (d * py - e * px)  # of the axle's path, to the left of the way
    turn = path[k, 2] + lean - pose.turn
    turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    error = error_of(now, pose)
    _, along = sincos(error.turn)
    speed = max(way * (along * now[3] + params.position_gain * error.along), 0.0)
    delta = turn + math.atan(params.gain * aside / (params.softening + speed))
    curvature = math.tan(min(max(delta, -STEEPEST), STEEPEST)) / params.lead
    return towards(params.limits, before, way, speed, curvature)


STANLEY = Method(
    "steer the leading axle onto the path, by heading and cross-track error",
    lambda settings: PathLaw(stanley_step, settings),
    "Hoffmann, Tomlin, Montemerlo, Thrun, ACC 2007",
    StanleySettings,
)
