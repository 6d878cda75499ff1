"""One axis, closed: motor, friction, gear and encoder under the cascade, at 10, 2 and 1 kHz, in one compiled loop."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from holonom.control import (
    CascadeGains,
    CurrentParams,
    PositionParams,
    ServoAxis,
    SpeedParams,
    current_step,
    design_cascade,
    position_step,
    speed_step,
)
from holonom.devices import (
    ArmatureParams,
    DcMotor,
    Encoder,
    EncoderParams,
    Friction,
    FrictionParams,
    Gear,
    GearParams,
    StictionParams,
    TrackingParams,
    TrackingState,
    armature_step,
    count_angle,
    encoder_counter,
    extend_counter,
    gear_torque,
    stiction_step,
    tracking_params,
    tracking_step,
)
from holonom.trace.code.loops import loop

DT = 1e-4

# Puma 560 (specification 03.1): Armstrong's torque constants, Corke's resistances; inductances are assumed.
TORQUE_CONSTANT = (0.189, 0.219, 0.202, 0.075, 0.066, 0.066)
RESISTANCE = (2.1, 2.1, 2.1, 6.7, 6.7, 6.7)
INDUCTANCE = (4.9e-3, 4.9e-3, 4.9e-3, 10e-3, 10e-3, 10e-3)
RATIO = (-62.61, 107.82, -53.71, 76.04, 71.92, 76.69)
VISCOUS = (1.48e-3, 0.817e-3, 1.38e-3, 71.2e-6, 82.6e-6, 36.7e-6)
COULOMB = ((0.395, 0.435), (0.126, 0.071), (0.132, 0.105), (0.0112, 0.0169), (0.00926, 0.0145), (0.00396, 0.0105))
INERTIA = (3.5, 4.5, 1.0, 0.2, 0.18, 0.19)  # at the joint, rotor included
TORQUE = (97.6, 186.4, 89.4, 24.2, 20.1, 21.3)  # at the joint
SPEED = tuple(math.radians(v) for v in (82, 54, 122, 228, 241, 228))
COUNTS = (1000, 800, 1000, 1000, 1000, 1000)
SUPPLY = 40.0


class Axis(NamedTuple):
    armature: ArmatureParams
    friction: StictionParams
    known_friction: FrictionParams  # as a controller feeds it forward
    gear: GearParams
    encoder: EncoderParams
    tracking: TrackingParams
    current: CurrentParams
    speed: SpeedParams
    position: PositionParams
    torque_constant: float
    inertia: float  # at the joint, the real one
    assumed_inertia: float  # at the motor, the one the observer believes in


class Records(NamedTuple):
    """One row per 0.1 ms; joint units."""

    q: np.ndarray
    qd: np.ndarray
    current: np.ndarray
    voltage: np.ndarray
    current_reference: np.ndarray


def puma_axis(number: int, *, friction: bool = True, counts: int | None = None) -> tuple[Axis, CascadeGains]:
    """Axis 1 ... 6 of a Puma 560 with its load inertia, and its gains."""
    k = number - 1
    counts = counts or COUNTS[k]
    max_current = TORQUE[k] / abs(RATIO[k]) / TORQUE_CONSTANT[k]
    inertia = INERTIA[k] / RATIO[k] ** 2
    motor = DcMotor(
        RESISTANCE[k],
        INDUCTANCE[k],
        TORQUE_CONSTANT[k],
        TORQUE_CONSTANT[k],
        2e-4 if number < 4 else 3.3e-5,
        SUPPLY,
        max_current,
    )
    gains = design_cascade(
        ServoAxis(
            resistance=motor.resistance,
            inductance=motor.inductance,
            torque_constant=motor.torque_constant,
            back_emf_constant=motor.back_emf_constant,
            inertia=inertia,
            max_voltage=motor.max_voltage,
            max_current=motor.max_current,
            max_speed=SPEED[k] * abs(RATIO[k]),
            counts_per_rev=counts,
            viscous=VISCOUS[k],
        )
    )
    rubbing = Friction(VISCOUS[k], *COULOMB[k]) if friction else Friction()
    axis = Axis(
        armature=motor.armature(DT),
        friction=rubbing.stiction(inertia, DT),
        known_friction=rubbing.params(1.0),
        gear=Gear(RATIO[k]).params(),
        encoder=Encoder(counts).params(),
        tracking=tracking_params(gains.observer_bandwidth, DT),
        current=gains.current,
        speed=gains.speed,
        position=gains.position,
        torque_constant=motor.torque_constant,
        inertia=INERTIA[k],
        assumed_inertia=inertia,
    )
    return axis, gains


def simulate(
    axis: Axis,
    q_ref: np.ndarray,
    qd_ref: np.ndarray,
    *,
    load: np.ndarray | float = 0.0,
    qdd_ref: np.ndarray | None = None,
    inner: bool = False,
) -> Records:
    """Run references (joint, one row per 1 ms); `inner` leaves the position loop open: qd_ref is the speed."""
    n = len(q_ref)
    loads = np.broadcast_to(np.asarray(load, dtype=float), (n,)).copy()
    out = np.zeros((5, 10 * n))
    _loop(axis, q_ref, qd_ref, np.zeros(n) if qdd_ref is None else qdd_ref, loads, inner, out)
    return Records(*out)


@loop
def _loop(axis, q_ref, qd_ref, qdd_ref, loads, inner, out):
    nu = axis.gear.ratio
    q = q_ref[0]
    qd = 0.0
    current = 0.0
    held = 0.0
    voltage_integral = 0.0
    current_integral = 0.0
    total = np.int64(math.floor(nu * q * axis.encoder.counts_per_rad))
    shaft = TrackingState(count_angle(axis.encoder, total), 0.0, 0.0)
    for tick in range(out.shape[1]):
        k = tick // 10
        total = extend_counter(total, encoder_counter(axis.encoder, nu * q))
        angle = count_angle(axis.encoder, total)
        if tick % 10 == 0:
            wanted = position_step(axis.position, nu * q_ref[k], nu * qd_ref[k], angle)
            if inner:
                wanted = nu * qd_ref[k]
        if tick % 5 == 0:
            known = axis.assumed_inertia * nu * qdd_ref[k] / axis.torque_constant
            reference, current_integral = speed_step(axis.speed, current_integral, wanted, shaft.speed, known)
        voltage, voltage_integral = current_step(axis.current, voltage_integral, reference, current, shaft.speed)
        current_after = armature_step(axis.armature, current, voltage, nu * qd)
        mean = 0.5 * (current + current_after)
        rubbed, held = stiction_step(axis.friction, held, nu * qd)
        shaft_torque = axis.torque_constant * mean - rubbed
        qdd = (gear_torque(axis.gear, shaft_torque, nu * qd) - loads[k]) / axis.inertia
        shaft = tracking_step(axis.tracking, shaft, angle, axis.torque_constant * current / axis.assumed_inertia)
        out[0, tick] = q
        out[1, tick] = qd
        out[2, tick] = current
        out[3, tick] = voltage
        out[4, tick] = reference
        current = current_after
        qd += DT * qdd
        q += DT * qd
    return total


def trapezoid(distance: float, speed: float, acceleration: float, rest: float) -> tuple[np.ndarray, ...]:
    """Position, speed, acceleration of a trapezoidal profile at 1 kHz with `rest` seconds at its end."""
    ramp = speed / acceleration
    cruise = distance / speed - ramp
    assert cruise >= 0.0
    t = np.arange(0.0, 2.0 * ramp + cruise + rest, 1e-3)
    qdd = np.where(t < ramp, acceleration, 0.0) - np.where(
        (t >= ramp + cruise) & (t < 2.0 * ramp + cruise), acceleration, 0.0
    )
    up = np.clip(t, 0.0, ramp)
    down = np.clip(t - ramp - cruise, 0.0, ramp)
    qd = acceleration * (up - down)
    flat = np.clip(t - ramp, 0.0, None)
    late = np.clip(t - ramp - cruise - ramp, 0.0, None)
    q = acceleration * (0.5 * up**2 + ramp * flat - 0.5 * down**2 - ramp * late)
    return q, qd, qdd
