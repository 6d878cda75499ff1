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
    "field_reference",
    "field_step",
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
def field_reference(params: FieldParams, torque: float, speed: float) -> Dq:
    """Currents (A) for a torque (N m) at a speed (rad/s, shaft), within all limits; as near as they allow."""
    motor = params.motor
    p, psi, ld, lq = motor.pole_pairs, motor.flux, motor.inductance_d, motor.inductance_q
    saliency = lq - ld
    # torque = 3/4 p i_q (psi + sqrt(psi^2 + 4 D^2 i_q^2)) along the best angle: Newton from above
    wanted = abs(torque)
    q = wanted / (1.5 * p * psi)
    for _ in range(6):
        root = math.sqrt(psi * psi + 4.0 * saliency * saliency * q * q)
        slope = 0.75 * p * (psi + root + 4.0 * saliency * saliency * q * q / root)
        q = max(q - (0.75 * p * q * (psi + root) - wanted) / slope, 0.0)
    root = math.sqrt(psi * psi + 4.0 * saliency * saliency * q * q)
    d = -2.0 * saliency * q * q / (psi + root)
    if d * d + q * q > params.current * params.current:
        root = math.sqrt(psi * psi + 8.0 * saliency * saliency * params.current * params.current)
        d = -2.0 * saliency * params.current * params.current / (psi + root)
        q = math.sqrt(params.current * params.current - d * d)
    w = p * abs(speed)
    drives = 1.0 if torque * speed >= 0.0 else -1.0  # driving, the resistance takes voltage; braking, it gives
    most = params.voltage * params.used
    u_d, u_q = motor.resistance * d - w * lq * q * drives, motor.resistance * q * drives + w * (ld * d + psi)
    if u_d * u_d + u_q * u_q > most * most:
        d, q = _weakened(params, wanted, w, drives)
    else:
        d = max(d, -params.demagnetising)
    return Dq(d, math.copysign(q, torque))


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
    for _ in range(7):  # the best of nine points, then of nine about it
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
        centre, spread = best_d, 0.4 * spread
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
    left = math.sqrt(max(params.voltage * params.voltage - d * d, 0.0))
    q = min(max(asked_q, -left), left)
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
    for k in range(torque.size):
        reference = field_reference(params, torque[k], speed)
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
