"""Compiled steps of one servo axis: scalars and NamedTuples in, scalars out; nothing is checked or allocated.

The cascade works in motor units (rad, rad/s, A, V at the motor shaft). Its only states are the integrals of
the two PI regulators; a loop keeps them per axis and passes them back in.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop

__all__ = [
    "AccelerationParams",
    "CurrentParams",
    "LimitParams",
    "PiParams",
    "PositionParams",
    "SpeedParams",
    "acceleration_step",
    "axis_violation",
    "current_step",
    "pi_start",
    "pi_step",
    "position_step",
    "speed_step",
    "torque_to_current",
]


class PiParams(NamedTuple):
    """PI regulator: `K_c`, `K_i = K_c T_s / T_i`."""

    gain: float
    integral_gain: float


class CurrentParams(NamedTuple):
    """Current loop: PI in V/A, supply in V, back-emf constant for the feed-forward in V s/rad (0: none)."""

    gain: float
    integral_gain: float
    max_voltage: float
    back_emf: float


class SpeedParams(NamedTuple):
    """Speed loop: PI in A s/rad, current limit in A; supply, k_e and 1/R tell what the supply can drive."""

    gain: float
    integral_gain: float
    max_current: float
    max_voltage: float
    back_emf: float
    conductance: float


class PositionParams(NamedTuple):
    """Position loop: gain in 1/s, speed limit in rad/s, braking the axis is trusted with in rad/s^2."""

    gain: float
    max_speed: float
    max_braking: float


class AccelerationParams(NamedTuple):
    """Acceleration law: k_p in 1/s^2, k_v in 1/s, `k_i T_s` in 1/s^2, limit of the correction in rad/s^2."""

    position_gain: float
    speed_gain: float
    integral_gain: float
    max_correction: float


class LimitParams(NamedTuple):
    """Limits of one axis: position (lower, upper), speed, current, following error."""

    lower: float
    upper: float
    speed: float
    current: float
    following_error: float


@loop
def pi_step(
    params: PiParams, integral: float, error: float, feedforward: float, low: float, high: float
) -> tuple[float, float]:
    """PI with conditional integration (spec 04.1): output in [low, high] and the next integral.

    `v = K_c e + i + K_i e + ff; u = clip(v)`: the integral takes `K_i e` unless the output is at a limit and the error
    pushes it further. It neither winds up nor recoils: a single wrong reading leaves the integral as it was, where
    integrator reset throws the output to the other limit (spec 04.5).
    """
    grown = integral + params.integral_gain * error
    wanted = params.gain * error + grown + feedforward
    output = min(max(wanted, low), high)
    return output, select((wanted - output) * error > 0.0, integral, grown)


@loop
def pi_start(params: PiParams, output: float, error: float, feedforward: float) -> float:
    """Integral with which the next `pi_step` gives `output`: bumpless start, or transfer from manual."""
    return output - feedforward - (params.gain + params.integral_gain) * error


@loop
def current_step(
    params: CurrentParams, integral: float, reference: float, current: float, speed: float
) -> tuple[float, float]:
    """Voltage (V) within the supply, and the next integral (V), from currents (A) and motor speed (rad/s)."""
    pi = PiParams(params.gain, params.integral_gain)
    ahead = params.back_emf * speed
    return pi_step(pi, integral, reference - current, ahead, -params.max_voltage, params.max_voltage)


@loop
def speed_step(
    params: SpeedParams, integral: float, reference: float, speed: float, feedforward: float
) -> tuple[float, float]:
    """Current reference (A) and the next integral (A) from motor speeds (rad/s).

    `feedforward` (A) is the current that a model or an observer already knows of. The reference stays within
    the current limit and within what the supply can drive against the back-emf at this speed, so that a
    voltage limit does not wind the speed loop up either.
    """
    pi = PiParams(params.gain, params.integral_gain)
    emf = params.back_emf * speed
    limit = params.max_current
    high = max(min(limit, params.conductance * (params.max_voltage - emf)), -limit)
    low = min(max(-limit, params.conductance * (-params.max_voltage - emf)), limit)
    return pi_step(pi, integral, reference - speed, feedforward, low, high)


@loop
def position_step(params: PositionParams, reference: float, feedforward: float, position: float) -> float:
    """Speed reference (rad/s) from motor positions (rad) and the speed of the reference (rad/s).

    Proportional for small errors; beyond `a / k^2` the root that the axis can brake on with deceleration a,
    which continues the line in value and slope. A long step therefore ends without overshoot.
    """
    error = reference - position
    distance = abs(error)
    braking = params.max_braking
    corner = braking / (params.gain * params.gain)
    if distance <= corner:
        approach = params.gain * error
    else:
        approach = math.copysign(math.sqrt(braking * (2.0 * distance - corner)), error)
    return min(max(approach + feedforward, -params.max_speed), params.max_speed)


@loop
def acceleration_step(
    params: AccelerationParams,
    integral: float,
    position_error: float,
    speed_error: float,
    acceleration: float,
    saturated: bool,
) -> tuple[float, float]:
    """Joint acceleration (rad/s^2) for the inverse dynamics, and the next integral (rad/s^2); spec 04.4.

    `u = qdd_ref + k_v (qd_ref - qd) + k_p (q_ref - q) + k_i integral`, errors as reference minus measured
    (rad, rad/s). The correction is clipped; the integral stands still while that is so and the position error pushes it
    further, and while the drive of the axis is `saturated`.
    """
    grown = integral if saturated else integral + params.integral_gain * position_error
    wanted = params.speed_gain * speed_error + params.position_gain * position_error + grown
    correction = min(max(wanted, -params.max_correction), params.max_correction)
    return acceleration + correction, integral if (wanted - correction) * position_error > 0.0 else grown


@loop
def torque_to_current(torque: float, torque_per_ampere: float, max_current: float) -> tuple[float, bool]:
    """Current reference (A) for a joint torque (N m) by signed `G k_t` (N m/A); whether it was clipped."""
    wanted = torque / torque_per_ampere
    current = min(max(wanted, -max_current), max_current)
    return current, current != wanted


@loop
def axis_violation(limits: LimitParams, reference: float, position: float, speed: float, current: float) -> int:
    """Code of the first limit that does not hold (`Violation`), 0 when all do; NaN never holds."""
    if not math.isfinite(reference):
        return 1
    if not position >= limits.lower:
        return 2
    if not position <= limits.upper:
        return 3
    if not abs(reference - position) <= limits.following_error:
        return 4
    if not abs(speed) <= limits.speed:
        return 5
    if not abs(current) <= limits.current:
        return 6
    return 0
