"""One axis as it truly is, compiled: armature, rotor, gear with its gap, load; everything at the motor shaft.

A rigid axis is one inertia; with a gap or an elastic shaft rotor and load are two. Friction holds both at standstill.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.devices.motors.kernels import ArmatureParams, armature_step
from holonom.devices.transmission.kernels import sliding_speed
from holonom.trace.code.loops import loop

__all__ = ["AxisPlantParams", "AxisState", "axis_step"]


class AxisPlantParams(NamedTuple):
    """Params of `axis_step`: N m, rad, s at the motor shaft; `per_torque` is dt / (J + B dt)."""

    dt: float
    armature: ArmatureParams
    torque_constant: float
    per_torque: float  # of the rotor; of rotor and load where the axis is rigid
    viscous: float
    coulomb_positive: float
    coulomb_negative: float
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
    """
    p = params
    current = armature_step(p.armature, state.current, voltage, state.speed) if conducts else 0.0
    drive = p.torque_constant * 0.5 * (state.current + current)
    loss = p.lost * abs(state.torque)
    if p.rigid:
        rubbing = p.mean * p.load_coulomb + loss + brake
        push = drive - p.mean * load - (p.viscous + p.mean * p.load_viscous) * state.speed
        speed = sliding_speed(
            state.speed, push, p.coulomb_positive + rubbing, p.coulomb_negative + rubbing, p.per_torque
        )
        carried = load + p.load_viscous * speed + (speed - state.speed) / p.load_per_torque
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
    push = drive - p.mean * torque - p.viscous * state.speed
    rubbing = loss + brake
    speed = sliding_speed(state.speed, push, p.coulomb_positive + rubbing, p.coulomb_negative + rubbing, p.per_torque)
    pull = torque - load - p.load_viscous * state.load_speed
    load_speed = sliding_speed(state.load_speed, pull, p.load_coulomb, p.load_coulomb, p.load_per_torque)
    return AxisState(
        current, speed, state.angle + p.dt * speed, load_speed, state.load_angle + p.dt * load_speed, torque
    )
