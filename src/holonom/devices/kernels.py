"""Compiled steps of the devices: scalars and NamedTuples in, scalars out; nothing is checked or allocated.

Params come from the data sheets beside this file (`DcMotor.armature`, `Encoder.params`, ...). All angles and
speeds are the motor shaft's unless the name says joint.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop

__all__ = [
    "COUNTER_SIZE",
    "ArmatureParams",
    "EncoderParams",
    "FrictionParams",
    "GearParams",
    "LuGreParams",
    "StictionParams",
    "TrackingParams",
    "TrackingState",
    "armature_step",
    "count_angle",
    "difference_speed",
    "encoder_counter",
    "extend_counter",
    "friction_torque",
    "gear_torque",
    "lugre_step",
    "stiction_step",
    "tracking_step",
]

COUNTER_SIZE = 1 << 16
HALF_COUNTER = COUNTER_SIZE >> 1


class ArmatureParams(NamedTuple):
    """An armature at one fixed interval: decay `exp(-R dt / L)`, 1/R in S, k_e in V s/rad, supply in V."""

    decay: float
    conductance: float
    back_emf: float
    max_voltage: float


class FrictionParams(NamedTuple):
    """Viscous in N m s/rad; Coulomb magnitudes in N m for speed > 0 and < 0; smoothing in rad/s."""

    viscous: float
    coulomb_positive: float
    coulomb_negative: float
    smoothing: float


class StictionParams(NamedTuple):
    """Viscous in N m s/rad; Coulomb magnitudes in N m for speed > 0 and < 0; N m that a step at 1 rad/s winds up."""

    viscous: float
    coulomb_positive: float
    coulomb_negative: float
    winding: float


class LuGreParams(NamedTuple):
    """Bristles: sigma_0, sigma_1, sigma_2; F_c, F_s in N or N m; Stribeck speed; step, s."""

    stiffness: float
    damping: float
    viscous: float
    coulomb: float
    static: float
    stribeck_speed: float
    dt: float


class GearParams(NamedTuple):
    """Motor turns per joint turn (signed) and efficiency in (0, 1]."""

    ratio: float
    efficiency: float


class EncoderParams(NamedTuple):
    """Counts per radian of the motor shaft after decoding, and its inverse in rad."""

    counts_per_rad: float
    resolution: float


class TrackingParams(NamedTuple):
    """A tracking loop at interval `dt`: corrections of angle (1), speed (1/s), load (1/s^2) per error."""

    dt: float
    angle_gain: float
    speed_gain: float
    load_gain: float


class TrackingState(NamedTuple):
    """Estimated angle (rad), speed (rad/s) and unmodelled acceleration (rad/s^2) of the motor shaft."""

    angle: float
    speed: float
    load: float


@loop
def armature_step(params: ArmatureParams, current: float, voltage: float, speed: float) -> float:
    """Current (A) one interval later, from `L di/dt = u - R i - k_e w`, exact for held `u`, `w` (03.1)."""
    supplied = min(max(voltage, -params.max_voltage), params.max_voltage)
    settled = params.conductance * (supplied - params.back_emf * speed)
    return settled + params.decay * (current - settled)


@loop
def friction_torque(params: FrictionParams, speed: float) -> float:
    """Torque (N m) that opposes the motion, to be subtracted: `B w + T_c w / sqrt(w^2 + e^2)`."""
    coulomb = select(speed > 0.0, params.coulomb_positive, params.coulomb_negative)
    sign = speed / math.sqrt(speed * speed + params.smoothing * params.smoothing)
    return params.viscous * speed + coulomb * sign


@loop
def stiction_step(params: StictionParams, held: float, speed: float) -> tuple[float, float]:
    """Torque (N m) that opposes the motion, to be subtracted, and what of it a shaft at rest is held by.

    Coulomb friction as a stop (Prandtl's element): a stiff spring that is wound by motion and slips at `T_c`. A load
    below that is held: the shaft stands, it does not creep. As much damping beside the spring brings it to rest.
    """
    low, high, winding = -params.coulomb_negative, params.coulomb_positive, params.winding * speed
    held = min(max(held + winding, low), high)
    return params.viscous * speed + min(max(held + winding, low), high), held


@loop
def lugre_step(params: LuGreParams, bristle: float, speed: float) -> tuple[float, float]:
    """Friction (N or N m) over a step at a speed, to be subtracted, and the bristles' deflection at its end.

    `z' = v - sigma_0 |v| z / g(v)`, `g = F_c + (F_s - F_c) exp(-(v / v_s)^2)`, `F = sigma_0 z + sigma_1 z' + sigma_2 v`
    (Canudas de Wit et al., 1995). The bristles are integrated exactly over the step: `z` nears `g sgn(v) / sigma_0` by
    `exp(-sigma_0 |v| dt / g)`, however stiff they are.
    """
    p, part = params, speed / params.stribeck_speed
    g = p.coulomb + (p.static - p.coulomb) * math.exp(-part * part)
    settled = math.copysign(g / p.stiffness, speed)
    after = settled + (bristle - settled) * math.exp(-p.stiffness * abs(speed) * p.dt / g)
    return p.stiffness * after + p.damping * (after - bristle) / p.dt + p.viscous * speed, after


@loop
def gear_torque(params: GearParams, motor_torque: float, motor_speed: float) -> float:
    """Joint torque (N m): `nu eta m` while the motor drives, `nu m / eta` when driven back (spec 03.2)."""
    if motor_torque * motor_speed >= 0.0:
        return params.ratio * params.efficiency * motor_torque
    return params.ratio * motor_torque / params.efficiency


@loop
def encoder_counter(params: EncoderParams, angle: float) -> int:
    """Content (0 ... 65535) of the 16-bit up/down counter at a motor angle (rad)."""
    return math.floor(angle * params.counts_per_rad) & (COUNTER_SIZE - 1)


@loop
def extend_counter(total: int, counter: int) -> int:
    """64-bit count after a read: the last one plus the signed 16-bit difference (spec 03.3).

    The low 16 bits of `total` are the last read, so `total` is the whole state. Right for any motion of less
    than 2^15 counts between two reads.
    """
    return total + ((counter - total + HALF_COUNTER) & (COUNTER_SIZE - 1)) - HALF_COUNTER


@loop
def count_angle(params: EncoderParams, total: int) -> float:
    """Motor angle (rad) at the middle of the count: off by half a count at most."""
    return (total + 0.5) * params.resolution


@loop
def difference_speed(params: EncoderParams, counts: int, interval: float) -> float:
    """M method: motor speed (rad/s) from the counts in an interval (s), `dN q / T_s`; half of it late."""
    return counts * params.resolution / interval


@loop
def tracking_step(params: TrackingParams, state: TrackingState, angle: float, acceleration: float) -> TrackingState:
    """One read of the encoder: predict with the known acceleration (`k_t i / J`, or 0), correct by the error.

    With the right inertia the speed has no delay. The load state takes up whatever the acceleration leaves
    out (gravity, friction, a wrong inertia), so that nothing constant biases the speed.
    """
    dt = params.dt
    total = acceleration + state.load
    predicted = state.angle + dt * (state.speed + 0.5 * dt * total)
    error = angle - predicted
    return TrackingState(
        predicted + params.angle_gain * error,
        state.speed + dt * total + params.speed_gain * error,
        state.load + params.load_gain * error,
    )
