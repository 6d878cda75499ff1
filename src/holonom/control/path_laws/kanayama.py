"""Kanayama's law: feedback on the pose error of the reference in time, critically damped at every speed."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.kernels import KeepingParams, Planar
from holonom.control.path_laws.contract import (
    CommandLimits,
    LawSettings,
    PathLaw,
    error_of,
    limited,
)
from holonom.registry import Method, parameter
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["KANAYAMA", "KanayamaParams", "KanayamaSettings", "kanayama_step", "line_keeping_step"]

SLOW = 0.2  # m/s, below which a base that cannot move sideways does not turn harder towards its path


class KanayamaParams(NamedTuple):
    """Gains in 1/s, limits of corrections in m/s and rad/s, limits of the command."""

    limits: CommandLimits
    position_gain: float
    heading_gain: float
    max_correction: float
    max_turn_correction: float


@dataclass(frozen=True, slots=True, kw_only=True)
class KanayamaSettings(LawSettings):
    """Kanayama's law; equations, stability and limits in `kanayama_step`.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    position_gain: float = parameter(3.0, meaning="speed per error along the way", unit="1/s", above=0.0)
    heading_gain: float = parameter(6.0, meaning="h: turning rate per sine of the heading error", unit="1/s", above=0.0)
    max_correction: float = parameter(0.6, meaning="speed that an error may add", unit="m/s", above=0.0, most=inf)
    max_turn_correction: float = parameter(
        4.0, meaning="turning rate that an error may add", unit="rad/s", above=0.0, most=inf
    )

    def params(self, dt: float) -> KanayamaParams:
        """Params of `kanayama_step` at a sample time, s."""
        return KanayamaParams(
            self.limits(dt),
            self.position_gain,
            self.heading_gain,
            self.max_correction,
            self.max_turn_correction,
        )


@loop(error_model="numpy")
def kanayama_step(
    params: KanayamaParams, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar,
    memory: Array,
) -> Planar:  # fmt: skip
    """Twist to command; arguments as `PathLaw` says.

    Notes
    -----
    Kanayama, Kimura, Miyazaki, Noguchi, *A stable tracking control method for an autonomous mobile robot*, ICRA 1990:
    `v = v_r cos e_theta + k e_x`, `w = w_r + h sin e_theta + h^2/(4 v_r) e_y`, whose error across obeys
    `e_y'' + h e_y' + h^2/4 e_y = 0` at every constant v_r.

    Stability: asymptotic for |v_r| above 0.2 m/s and |e_theta| < pi (Lyapunov function
    `(e_x^2 + e_y^2)/2 + (1 - cos e_theta)/K_y`, with `K_y = h^2/(4 v_r^2)`), while no limit is reached. Below
    0.2 m/s the term across fades with the speed: at rest an error across stays.
    """
    speed, rate = _wanted(
        params.position_gain, params.heading_gain, params.max_correction, params.max_turn_correction, now, pose
    )
    return limited(params.limits, before, speed, rate)


@loop(error_model="numpy")
def line_keeping_step(
    params: KeepingParams, reference: Array, pose: Planar, before: Planar
) -> tuple[Planar, Planar, Planar]:
    """`keeping_step` of a base that cannot move sideways and holds its pose: Kanayama's law; no integral."""
    speed, rate = _wanted(
        params.position_gain, params.heading_gain, params.max_correction, params.max_turn_correction, reference, pose
    )
    dt = params.dt
    command = Planar(
        before.x + _clip(speed - before.x, dt * params.max_acceleration),
        0.0,
        before.turn + _clip(rate - before.turn, dt * params.max_turn_acceleration),
    )
    return command, Planar(reference[6], reference[7], reference[8]), Planar(0.0, 0.0, 0.0)


@loop(error_model="numpy")
def _wanted(k: float, h: float, most: float, most_turn: float, reference: Array, pose: Planar) -> tuple[float, float]:
    """Speed and turning rate before the limits of a command."""
    error = error_of(reference, pose)
    e, d = sincos(error.turn)
    v = reference[3]
    steer = 0.25 * h * h * v / max(v * v, SLOW * SLOW)
    return d * v + _clip(k * error.along, most), reference[5] + _clip(h * e + steer * error.across, most_turn)


@loop(error_model="numpy")
def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


KANAYAMA = Method(
    "feedback on the pose error of the reference in time, critically damped",
    lambda settings: PathLaw(kanayama_step, settings),
    "Kanayama, Kimura, Miyazaki, Noguchi, ICRA 1990",
    KanayamaSettings,
)
