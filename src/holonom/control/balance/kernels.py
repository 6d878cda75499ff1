"""Compiled steps of balancing: where the body leans, and the force that keeps it up; all state in arguments."""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = [
    "BalanceGains",
    "Tilt",
    "TiltParams",
    "Upright",
    "asked_lean",
    "balance_step",
    "level_acceleration",
    "tilt_ahead",
    "tilt_step",
    "trim_step",
]

MOST_TRIM = 0.1  # rad that its rest may be off


class BalanceGains(NamedTuple):
    """Gains of a law: force per pitch (N/rad) and its rate (N s/rad); pitch asked per error of speed and place."""

    pitch: float
    pitch_rate: float
    lean_per_speed: float  # rad s/m
    lean_per_place: float  # rad/m
    carry: float  # N/rad: force that goes with a pitch that is asked for
    max_lean: float  # rad, of what errors ask for
    max_place: float  # m of error beyond which it counts no more
    max_force: float  # N
    trim_time: float  # s in which a lean that is asked for again and again is taken for the rest


class Upright(NamedTuple):
    """How a body that balances stands: pitch from its rest (rad), its rate, speed (m/s), place along its way (m)."""

    pitch: float
    rate: float
    speed: float
    place: float


class TiltParams(NamedTuple):
    """Gains of the estimate per m/s that the wheels' speed is off: of speed, pitch (rad s/m), gyro zero (rad/m)."""

    dt: float
    speed: float
    pitch: float
    bias: float


class Tilt(NamedTuple):
    """Estimate: speed (m/s), pitch (rad), zero of the pitch gyro (rad/s)."""

    speed: float
    pitch: float
    bias: float


@loop(error_model="numpy")
def asked_lean(gains: BalanceGains, seen: Upright, wanted: Upright) -> float:
    """Pitch (rad) that errors of speed and place ask for: back where it is too fast or too far ahead."""
    place = min(max(seen.place - wanted.place, -gains.max_place), gains.max_place)
    lean = -(gains.lean_per_speed * (seen.speed - wanted.speed) + gains.lean_per_place * place)
    return min(max(lean, -gains.max_lean), gains.max_lean)


@loop(error_model="numpy")
def trim_step(gains: BalanceGains, dt: float, trim: float, lean: float) -> float:
    """Pitch (rad) at which it rests, one sample later: slopes and payloads beside the axle are learnt slowly.

    Not while the lean that is asked for is the largest one: then something holds it, as an edge does.
    """
    if abs(lean) >= gains.max_lean:
        return trim
    return min(max(trim + dt / gains.trim_time * lean, -MOST_TRIM), MOST_TRIM)


@loop(error_model="numpy")
def balance_step(gains: BalanceGains, seen: Upright, wanted: Upright, ahead: float, trim: float = 0.0) -> float:
    """Force (N, along the way, of all rims) that keeps a body up and takes it to a speed and a place.

    Parameters
    ----------
    seen, wanted
        What is, and the motion that is asked for: a pitch that fits its acceleration, its speed, its place.
    ahead
        Force of that motion, N.
    trim
        What its rest is off, rad (`trim_step`).

    Notes
    -----
    Too fast or too far ahead, the body is asked to lean back, no further than `max_lean`:
    `phi_c = -(a (v - v_r) + b (p - p_r))`, `F = F_r + k (phi - phi_r - phi_c - phi_0) + d (phid - phid_r) + c phi_c`.
    The wheels first run the other way, as of every inverted pendulum: speed and place are not of minimum phase.
    """
    lean = asked_lean(gains, seen, wanted)
    force = ahead + gains.pitch * (seen.pitch - wanted.pitch - lean - trim)
    force += gains.pitch_rate * (seen.rate - wanted.rate) + gains.carry * lean
    return min(max(force, -gains.max_force), gains.max_force)


@loop(error_model="numpy")
def level_acceleration(pitch: float, ahead: float, up: float) -> float:
    """Acceleration (m/s2) over the floor of an IMU that leans, from what it measures along its x and z."""
    s, c = sincos(pitch)
    return c * ahead + s * up


@loop(error_model="numpy")
def tilt_ahead(params: TiltParams, tilt: Tilt, rate: float, ahead: float, up: float) -> Tilt:
    """Estimate one sample later by gyro (rad/s) and accelerometers (m/s2) alone."""
    pitch = tilt.pitch + params.dt * (rate - tilt.bias)
    return Tilt(tilt.speed + params.dt * level_acceleration(pitch, ahead, up), pitch, tilt.bias)


@loop(error_model="numpy")
def tilt_step(params: TiltParams, tilt: Tilt, speed: float) -> Tilt:
    """Estimate with the speed (m/s) that the wheels measure.

    Notes
    -----
    Kalman filter of speed, pitch and gyro zero with constant gains (Anderson & Moore, *Optimal Filtering*, 4.4):
    `v' = f_x cos phi + f_z sin phi`, `phi' = omega - b`. A pitch that is wrong takes part of gravity for acceleration,
    which the wheels do not see; so true accelerations do not disturb it, as they do a filter that takes the
    accelerometers for a plumb line.
    """
    off = speed - tilt.speed
    pitch = tilt.pitch + params.pitch * off
    pitch -= 2.0 * math.pi * math.floor(pitch / (2.0 * math.pi) + 0.5)
    return Tilt(tilt.speed + params.speed * off, pitch, tilt.bias + params.bias * off)
