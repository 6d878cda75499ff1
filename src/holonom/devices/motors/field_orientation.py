"""Field orientation: which currents make a torque at a speed, and the regulators that drive them (spec 03.1).

Reference: greatest torque per ampere, inside the current circle; beyond the voltage circle `i_d` weakens the field, no
further than the demagnetising current. Regulators: PI with the couplings `w L i` and the back-emf fed forward, clipped
to the voltage circle, d first; an integral stands while its output is clipped and its error pushes outwards.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, finite_array
from holonom.devices._checks import require
from holonom.devices.motors.pmsm import Dq, Pmsm, PmsmParams, pmsm_step, pmsm_torque
from holonom.errors import ModelError, ShapeError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = [
    "FieldOrientation",
    "FieldParams",
    "FieldState",
    "PmsmRun",
    "field_best",
    "field_reference",
    "field_step",
    "field_within",
    "run_pmsm",
]


class FieldParams(NamedTuple):
    """The motor, gains in V/A (integral: per sample), voltage circle in V, currents in A, part of it that is used."""

    motor: PmsmParams
    gain_d: float
    gain_q: float
    integral_gain: float
    voltage: float
    current: float
    demagnetising: float
    used: float


class FieldState(NamedTuple):
    """Integrals of the two regulators, V."""

    d: float
    q: float


@loop
def field_best(params: FieldParams, torque: float) -> Dq:
    """Currents (A) for a torque (N m) with the greatest torque per ampere, within the current circle."""
    motor = params.motor
    psi, twice = motor.flux, 2.0 * (motor.inductance_q - motor.inductance_d)
    q = _quadrature(abs(torque) / (0.75 * motor.pole_pairs), psi, twice)
    d = -twice * q * q / (psi + math.sqrt(psi * psi + twice * twice * q * q))
    square = params.current * params.current
    if d * d + q * q > square:
        d = -twice * square / (psi + math.sqrt(psi * psi + 2.0 * twice * twice * square))
        q = math.sqrt(square - d * d)
    return Dq(d, math.copysign(q, torque))


@loop
def field_within(params: FieldParams, best: Dq, torque: float, speed: float) -> Dq:
    """Currents (A) that the voltage circle and the magnets leave of the best ones at a speed (rad/s, shaft)."""
    motor = params.motor
    w = motor.pole_pairs * speed
    u_d = motor.resistance * best.d - w * motor.inductance_q * best.q
    u_q = motor.resistance * best.q + w * (motor.inductance_d * best.d + motor.flux)
    most = params.voltage * params.used
    if u_d * u_d + u_q * u_q <= most * most:
        return Dq(max(best.d, -params.demagnetising), best.q)
    drives = 1.0 if torque * speed >= 0.0 else -1.0  # driving, the resistance takes voltage; braking, it gives
    d, q = _weakened(params, abs(torque), abs(w), drives)
    return Dq(d, math.copysign(q, torque))


@loop
def field_reference(params: FieldParams, torque: float, speed: float) -> Dq:
    """Currents (A) for a torque (N m) at a speed (rad/s, shaft), within all limits; as near as they allow."""
    return field_within(params, field_best(params, torque), torque, speed)


@loop
def _quadrature(wanted: float, flux: float, twice: float) -> float:
    """Solve `wanted = i_q (psi + sqrt(psi^2 + (2 D i_q)^2))`, the torque along the best angle: Newton from above."""
    if twice == 0.0:
        return 0.5 * wanted / flux
    q = min(0.5 * wanted / flux, math.sqrt(wanted / abs(twice)))
    for _ in range(8):
        root = math.sqrt(flux * flux + twice * twice * q * q)
        change = (q * (flux + root) - wanted) * root / (root * (flux + root) + twice * twice * q * q)
        q -= change
        if change <= 1e-5 * q:  # squared, it is the error that is left
            break
    return q


@loop
def _weakened(params: FieldParams, wanted: float, w: float, drives: float) -> tuple[float, float]:
    """Currents within voltage ellipse and current circle with the greatest torque up to `wanted`, least current."""
    most = params.voltage * params.used
    motor = params.motor
    p, psi, ld, lq, r = motor.pole_pairs, motor.flux, motor.inductance_d, motor.inductance_q, motor.resistance
    most = params.voltage * params.used
    low = -min(params.current, params.demagnetising)
    best_d, best_q, best = low, 0.0, -1.0
    centre, spread = 0.5 * low, -0.5 * low
    for _ in range(5):  # the best of nine points, then of nine about it
        for k in range(9):
            d = min(max(centre + spread * (0.25 * k - 1.0), low), 0.0)
            # |u|^2 <= most^2 as a quadratic in q
            a = r * r + w * w * lq * lq
            b = drives * r * w * (psi + (ld - lq) * d)
            c = r * r * d * d + w * w * (ld * d + psi) ** 2 - most * most
            inside = b * b - a * c
            if inside < 0.0:
                continue
            q = (math.sqrt(inside) - b) / a
            q = min(q, math.sqrt(max(params.current * params.current - d * d, 0.0)))
            per = 1.5 * p * (psi + (ld - lq) * d)
            if q < 0.0 or per <= 0.0:
                continue
            q = min(q, wanted / per)
            made = per * q + 1e-6 * d * per  # of equal torques the one with less current
            if made > best:
                best_d, best_q, best = d, q, made
        centre, spread = best_d, 0.3 * spread
    return best_d, best_q


@loop
def field_step(
    params: FieldParams, state: FieldState, reference: Dq, current: Dq, speed: float
) -> tuple[Dq, FieldState]:
    """Voltages (V, dq, within the circle) for the next sample, and the integrals after it."""
    motor = params.motor
    w = motor.pole_pairs * speed
    error_d, error_q = reference.d - current.d, reference.q - current.q
    feed_d = -w * motor.inductance_q * current.q
    feed_q = w * (motor.inductance_d * current.d + motor.flux)
    integral_d = state.d + params.integral_gain * error_d
    integral_q = state.q + params.integral_gain * error_q
    asked_d = params.gain_d * error_d + integral_d + feed_d
    asked_q = params.gain_q * error_q + integral_q + feed_q
    d = min(max(asked_d, -params.voltage), params.voltage)
    q, square = asked_q, params.voltage * params.voltage - d * d
    if q * q > square:
        q = math.copysign(math.sqrt(max(square, 0.0)), q)
    if (asked_d - d) * error_d > 0.0:
        integral_d = state.d
    if (asked_q - q) * error_q > 0.0:
        integral_q = state.q
    return Dq(d, q), FieldState(integral_d, integral_q)


@loop
def _run(
    params: FieldParams,
    torque: Array,
    load: Array,
    inertia: float,
    viscous: float,
    start: float,
    dt: float,
    out: Array,
) -> None:
    """Run; a row of `out` each sample: time, speed, i_d, i_q, u_d, u_q, torque."""
    current, state, speed = Dq(0.0, 0.0), FieldState(0.0, 0.0), start
    asked, best = 0.0, Dq(0.0, 0.0)
    for k in range(torque.size):
        if torque[k] != asked:
            asked, best = torque[k], field_best(params, torque[k])
        reference = field_within(params, best, asked, speed)
        voltage, state = field_step(params, state, reference, current, speed)
        before = pmsm_torque(params.motor, current)
        current = pmsm_step(params.motor, current, voltage, speed, dt)
        after = pmsm_torque(params.motor, current)
        speed += dt * (0.5 * (before + after) - load[k] - viscous * speed) / inertia
        out[k, 0], out[k, 1] = dt * (k + 1), speed
        out[k, 2], out[k, 3] = current.d, current.q
        out[k, 4], out[k, 5], out[k, 6] = voltage.d, voltage.q, after


@dataclass(frozen=True, slots=True)
class FieldOrientation:
    """Settings of the current regulators.

    Raises
    ------
    ModelError
        A field outside its range.
    """

    sample: float = parameter(1e-4, meaning="time between samples", unit="s", above=0.0)
    speed_up: float = parameter(3.0, meaning="samples in which the current follows (gain L/(n T_s))", least=1.0)
    used: float = parameter(0.95, meaning="part of the voltage circle that references use", above=0.0, most=1.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def params(self, motor: Pmsm) -> FieldParams:
        """Params of `field_reference` and `field_step`: zeros on L/R, gains `L/(n T_s)`."""
        bandwidth = 1.0 / (self.speed_up * self.sample)
        return FieldParams(
            motor.params(),
            motor.inductance_d * bandwidth,
            motor.inductance_q * bandwidth,
            motor.resistance * bandwidth * self.sample,
            motor.phase_voltage,
            motor.max_current,
            motor.demagnetising_current,
            self.used,
        )


@dataclass(frozen=True, slots=True)
class PmsmRun:
    """A run of a PMSM drive, a row each sample: after it, voltages during it.

    Attributes
    ----------
    time, speed, torque
        s, rad/s of the shaft, N m, (n,).
    current, voltage
        d and q, A and V peak, (n, 2).
    """

    time: Array
    speed: Array
    current: Array
    voltage: Array
    torque: Array


def run_pmsm(
    motor: Pmsm,
    torque: ArrayLike,
    load: ArrayLike = 0.0,
    *,
    control: FieldOrientation = FieldOrientation(),
    load_inertia: float = 0.0,
    viscous: float = 0.0,
    speed: float = 0.0,
) -> PmsmRun:
    """Run a motor with field orientation, compiled, a sample at a time.

    Parameters
    ----------
    motor : with its limits.
    torque : reference, N m, (n,).
    load : torque against the shaft, N m, (n,) or one for all.
    control : sample time and gains.
    load_inertia : at the shaft, kg m^2.
    viscous : friction of the shaft, N m s/rad.
    speed : at the start, rad/s.

    Raises
    ------
    ModelError, ShapeError, NotFinite
    """
    asked = finite_array("torque", torque, ["n"])
    against = finite("load", load)
    if against.shape not in ((), asked.shape):
        raise ShapeError(f"load has shape {against.shape}; one number or {asked.shape} is needed")
    require("run_pmsm", "load_inertia", load_inertia, least=0.0)
    require("run_pmsm", "viscous", viscous, least=0.0)
    require("run_pmsm", "speed", speed)
    out = np.empty((asked.size, 7))
    against = np.ascontiguousarray(np.broadcast_to(against, asked.shape))
    inertia = motor.rotor_inertia + load_inertia
    _run(control.params(motor), asked, against, inertia, viscous, float(speed), control.sample, out)
    return PmsmRun(out[:, 0], out[:, 1], out[:, 2:4], out[:, 4:6], out[:, 6])
