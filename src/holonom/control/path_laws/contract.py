"""What all laws of paths share: errors seen from the robot, limits of a command, the place on the path, `PathLaw`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple, Protocol

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.registry import parameter
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = [
    "AHEAD",
    "CommandLimits",
    "Error",
    "LawSettings",
    "PathLaw",
    "along_limit",
    "command_limits",
    "curvature_limit",
    "direction_of",
    "error_of",
    "limited",
    "nearest",
    "nearness",
    "speed_limit",
    "towards",
    "turn_acceleration_limit",
    "turn_rate_limit",
]

AT, WAY, AHEAD = 0, 1, 7
"""Places in a law's memory (8,): index of the nearest sample, direction of the way (-1, 0, 1), and how near is what
lies ahead (0: nothing, 1: stop), which a planner sets (`nearness`)."""


class CommandLimits(NamedTuple):
    """Limits of a command: sample time (s), m/s, m/s^2, rad/s, rad/s^2, smallest turning radius (m)."""

    dt: float
    speed: float
    acceleration: float
    turn_rate: float
    turn_acceleration: float
    radius: float


class Error(NamedTuple):
    """The reference seen from the robot: ahead and to the left (m), turned by (rad, in (-pi, pi])."""

    along: float
    across: float
    turn: float


class LawSettings(Protocol):
    """Settings of a law: limits that its command never exceeds, and `params` of its compiled step."""

    @property
    def max_speed(self) -> float: ...  # noqa: D102
    @property
    def max_acceleration(self) -> float: ...  # noqa: D102
    @property
    def max_turn_rate(self) -> float: ...  # noqa: D102
    @property
    def max_turn_acceleration(self) -> float: ...  # noqa: D102
    @property
    def max_curvature(self) -> float: ...  # noqa: D102
    def params(self, dt: float) -> Any:
        """Params of the step at a sample time, s."""


@dataclass(frozen=True, slots=True)
class PathLaw:
    """A law and its settings.

    Attributes
    ----------
    step
        Compiled: `step(params, path, phase, now, pose, twist, before, memory)` gives the twist to command, a `Planar`
        (m/s, 0, rad/s). `path` (N, 9) holds pose in the world, twist in the base_link of that pose, acceleration, at
        1 kHz; `phase` is the index (float) of the time reference, `now` (9,) the reference there; `pose` and `twist`
        are estimates; `before` is the last command; `memory` (8,), zero at the start, is the law's own.
    settings
        `settings.params(dt)` are its params.
    """

    step: Callable[..., Planar]
    settings: LawSettings


def speed_limit() -> Any:
    """Field `max_speed` of a law's settings."""
    return parameter(2.0, meaning="of the command", unit="m/s", above=0.0, most=inf)


def along_limit() -> Any:
    """Field `max_acceleration`."""
    return parameter(3.0, meaning="of the commanded speed", unit="m/s2", above=0.0, most=inf)


def turn_rate_limit() -> Any:
    """Field `max_turn_rate`."""
    return parameter(6.0, meaning="of the command", unit="rad/s", above=0.0, most=inf)


def turn_acceleration_limit() -> Any:
    """Field `max_turn_acceleration`."""
    return parameter(40.0, meaning="of the commanded turning rate", unit="rad/s2", above=0.0, most=inf)


def curvature_limit() -> Any:
    """Field `max_curvature`."""
    return parameter(
        inf, meaning="of what is driven: 1 over the smallest turning radius", unit="1/m", above=0.0, most=inf
    )


def command_limits(settings: LawSettings, dt: float) -> CommandLimits:
    """Return the limits in a law's settings at a sample time, s."""
    return CommandLimits(
        dt=dt,
        speed=settings.max_speed,
        acceleration=settings.max_acceleration,
        turn_rate=settings.max_turn_rate,
        turn_acceleration=settings.max_turn_acceleration,
        radius=1.0 / settings.max_curvature,
    )


def nearness(distance: float, slow: float, stop: float) -> float:
    """How near something ahead is: 0 beyond the distance `slow`, 1 within `stop`, m; for `memory[AHEAD]`."""
    return min(max((slow - distance) / (slow - stop), 0.0), 1.0)


@loop(error_model="numpy")
def error_of(reference: Array, pose: Planar) -> Error:
    """The reference pose (first three of it) in the axes of a robot (Kanayama's error coordinates)."""
    s, c = sincos(pose.turn)
    x, y = reference[0] - pose.x, reference[1] - pose.y
    turn = reference[2] - pose.turn
    turn -= 2.0 * math.pi * math.floor(turn / (2.0 * math.pi) + 0.5)
    return Error(c * x + s * y, c * y - s * x, turn)


@loop(error_model="numpy")
def limited(limits: CommandLimits, before: Planar, speed: float, rate: float) -> Planar:
    """The command nearest to a wanted one that keeps all limits, if the last one did.

    Speed and turning rate are limited, then their change. Where the base must not turn that sharply, it turns less;
    and where it cannot unwind its turning fast enough, it brakes less: the last command itself is always allowed.
    """
    dv, dw = limits.dt * limits.acceleration, limits.dt * limits.turn_acceleration
    v = min(max(speed, -limits.speed), limits.speed)
    v = min(max(v, before.x - dv), before.x + dv)
    w = min(max(rate, -limits.turn_rate), limits.turn_rate)
    w = min(max(w, before.turn - dw), before.turn + dw)
    if limits.radius <= 0.0:
        return Planar(v, 0.0, w)
    least = limits.radius * max(abs(before.turn) - dw, 0.0)
    if least > 0.0 and v * math.copysign(1.0, before.x) < least:
        v = math.copysign(least, before.x)
    most = abs(v) / limits.radius
    return Planar(v, 0.0, min(max(w, -most), most))


@loop(error_model="numpy")
def towards(limits: CommandLimits, before: Planar, way: float, speed: float, curvature: float) -> Planar:
    """The command that drives a curve (1/m to the left, per way driven either way) at a speed, within limits.

    A curve sharper than the base can turn is cut to its sharpest; too fast a turn takes speed, not curvature.
    """
    if abs(curvature) * limits.radius > 1.0:
        curvature = math.copysign(1.0 / limits.radius, curvature)
    if speed * abs(curvature) > limits.turn_rate:
        speed = limits.turn_rate / abs(curvature)
    return limited(limits, before, way * speed, speed * curvature)


@loop(error_model="numpy")
def direction_of(path: Array, phase: float, memory: Array) -> float:
    """Which way the path goes at a phase: 1 forwards, -1 backwards; at rest as it goes on, at its end as it came.

    What lies between is remembered; the memory's nearest sample is put where the reference is, when the way turns.
    """
    last = path.shape[0] - 1
    k = min(max(int(phase), 0), last)
    way = memory[WAY]
    if path[k, 3] * way <= 0.0:
        found = path[k, 3]
        j = k
        while found == 0.0 and j < last:
            j += 1
            found = path[j, 3]
        turned = 0.0 if found == 0.0 else math.copysign(1.0, found)
        if turned != 0.0 and turned != way:
            memory[WAY] = way = turned
            memory[AT] = k
    return way if way != 0.0 else 1.0


@loop(error_model="numpy")
def nearest(path: Array, phase: float, way: float, x: float, y: float, lead: float, memory: Array) -> int:
    """Sample of the path nearest to a point (m), found downhill from the last one, on the stretch without a cusp.

    With `lead` (m), the point is compared with the places that lie so far ahead of the path's poses.
    """
    last = path.shape[0] - 1
    k = min(max(int(memory[AT]), 0), last)
    here = _square_to(path, k, way * lead, x, y)
    step = 1
    for _ in range(2):
        while 0 <= k + step <= last and path[k + step, 3] * way >= 0.0:
            there = _square_to(path, k + step, way * lead, x, y)
            if there > here or (step < 0 and there == here):
                break
            k, here = k + step, there
        step = -1
    memory[AT] = k
    return k


@loop(error_model="numpy")
def _square_to(path: Array, k: int, lead: float, x: float, y: float) -> float:
    dx, dy = path[k, 0] - x, path[k, 1] - y
    if lead != 0.0:
        s, c = sincos(path[k, 2])
        dx += lead * c
        dy += lead * s
    return dx * dx + dy * dy
