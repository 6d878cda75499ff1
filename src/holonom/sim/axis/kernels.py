"""One axis as it truly is, compiled: armature, rotor, gear with its gap, load; everything at the motor shaft.

A rigid axis is one inertia; with a gap or an elastic shaft rotor and load are two. Friction holds both at standstill.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.devices.motors.kernels import ArmatureParams
from holonom.devices.transmission.kernels import sliding_speed, stribeck
from holonom.trace.code.loops import loop

__all__ = ["AxisPlantParams", "AxisState", "axis_step"]


class AxisPlantParams(NamedTuple):
    """Params of `axis_step`: N m, rad, s at the motor shaft; `per_torque` is dt / (J + B dt).

    `torque_before` and `torque_after` are the parts of k_t for the mean of the current over a step, from the one before
    it and the one after it (`DcMotor.mean_weight`).
    """

    dt: float
    armature: ArmatureParams
    torque_before: float
    torque_after: float
    per_torque: float  # of the rotor; of rotor and load where the axis is rigid
    viscous: float
    coulomb_positive: float
    coulomb_negative: float
    rise: float  # of Coulomb friction towards rest: `devices.stribeck`
    per_stribeck: float
    load_per_torque: float
    load_viscous: float
    load_coulomb: float
    rigid: bool
    half_gap: float
    stiffness: float
    damping: float
    mean: float  # (1 / eta + eta) / 2 of the gear
    lost: float  # (1 / eta - eta) / 2


class AxisState(NamedTuple):
    """State of an axis at the motor shaft: A; rad/s and rad of rotor and load; N m through the gear."""

    current: float
    speed: float
    angle: float
    load_speed: float
    load_angle: float
    torque: float


@loop(error_model="numpy", forceinline=True)
def axis_step(
    params: AxisPlantParams, state: AxisState, voltage: float, load: float, brake: float = 0.0, conducts: bool = True
) -> AxisState:
    """One step under a voltage (V) and a torque on the load (N m, against its motion in the positive direction).

    `brake` is what a holding brake on the motor's shaft holds, N m; a winding that does not conduct has no current.

    The gear's loss is friction that grows with the torque it carries: the motor feels T / eta while it drives,
    T eta while it is driven back, and anything between at standstill.

    What does not wait for the new current is summed up first (`early`): each step waits for the one before, and the
    order of the sums is what a run's time depends on.
    """
    p, a = params, params.armature
    supplied = min(max(voltage, -a.max_voltage), a.max_voltage)
    alone = a.decay * state.current + (1.0 - a.decay) * a.conductance * supplied  # `armature_step`, but for its end
    current = alone - (1.0 - a.decay) * a.conductance * a.back_emf * state.speed if conducts else 0.0
    loss = p.lost * abs(state.torque)
    positive, negative = p.coulomb_positive, p.coulomb_negative
    if p.rise > 0.0:
        grown = stribeck(p.rise, p.per_stribeck, state.speed)
        positive, negative = grown * positive, grown * negative
    if p.rigid:
        held = p.mean * p.load_coulomb + brake + loss
        push = p.torque_before * state.current - p.mean * load - (p.viscous + p.mean * p.load_viscous) * state.speed
        early = state.speed + p.per_torque * push
        speed = sliding_speed(early, p.torque_after * current, positive + held, negative + held, p.per_torque)
        carried = load + p.load_viscous * speed + (speed - state.speed) * (1.0 / p.load_per_torque)
        if speed != 0.0:
            carried += math.copysign(p.load_coulomb, speed)
        angle = state.angle + p.dt * speed
        return AxisState(current, speed, angle, speed, angle, carried)
    rate = state.speed - state.load_speed
    twist = state.angle - state.load_angle
    torque = 0.0
    if twist > p.half_gap:
        torque = max(p.stiffness * (twist - p.half_gap + p.dt * rate) + p.damping * rate, 0.0)
    elif twist < -p.half_gap:
        torque = min(p.stiffness * (twist + p.half_gap + p.dt * rate) + p.damping * rate, 0.0)
    early = state.speed + p.per_torque * (p.torque_before * state.current - p.mean * torque - p.viscous * state.speed)
    held = brake + loss
    speed = sliding_speed(early, p.torque_after * current, positive + held, negative + held, p.per_torque)
    pull = torque - load - p.load_viscous * state.load_speed
    load_speed = sliding_speed(state.load_speed, pull, p.load_coulomb, p.load_coulomb, p.load_per_torque)
    return AxisState(
        current, speed, state.angle + p.dt * speed, load_speed, state.load_angle + p.dt * load_speed, torque
    )
