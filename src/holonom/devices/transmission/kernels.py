"""Compiled steps between motor and joint: gear, friction; scalars in, scalars out, nothing is checked or allocated.

Angles and speeds are the motor shaft's unless the name says joint.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop

__all__ = [
    "FrictionParams",
    "GearParams",
    "LuGreParams",
    "StictionParams",
    "friction_torque",
    "gear_torque",
    "geared_step",
    "lugre_step",
    "sliding_speed",
    "stiction_step",
    "stribeck",
]


class FrictionParams(NamedTuple):
    """Viscous in N m s/rad; Coulomb magnitudes in N m for speed > 0 and < 0; smoothing in rad/s; `stribeck`."""

    viscous: float
    coulomb_positive: float
    coulomb_negative: float
    smoothing: float
    rise: float
    per_stribeck: float


class StictionParams(NamedTuple):
    """Viscous in N m s/rad; Coulomb magnitudes in N m for speed > 0 and < 0; N m that a step at 1 rad/s winds up.

    `rise` and `per_stribeck` (s/rad) are those of `stribeck`, 0 where friction at rest is no greater.
    """

    viscous: float
    coulomb_positive: float
    coulomb_negative: float
    winding: float
    rise: float
    per_stribeck: float


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


@loop(forceinline=True)
def stribeck(rise: float, per_stribeck: float, speed: float) -> float:
    """Times by which Coulomb friction is greater at a speed: `1 + (r - 1) / (1 + (w / w_s)^2)` (Hess & Soom 1990)."""
    part = speed * per_stribeck
    return 1.0 + rise / (1.0 + part * part)


@loop
def friction_torque(params: FrictionParams, speed: float) -> float:
    """Torque (N m) that opposes the motion, to be subtracted: `B w + T_c w / sqrt(w^2 + e^2)`, T_c by `stribeck`."""
    grown = stribeck(params.rise, params.per_stribeck, speed)
    coulomb = grown * select(speed > 0.0, params.coulomb_positive, params.coulomb_negative)
    sign = speed / math.sqrt(speed * speed + params.smoothing * params.smoothing)
    return params.viscous * speed + coulomb * sign


@loop
def stiction_step(params: StictionParams, held: float, speed: float) -> tuple[float, float]:
    """Torque (N m) that opposes the motion, to be subtracted, and what of it a shaft at rest is held by.

    Coulomb friction as a stop (Prandtl's element): a stiff spring that is wound by motion and slips at `T_c`. A load
    below that is held: the shaft stands, it does not creep. As much damping beside the spring brings it to rest.
    `T_c` falls from its value at rest by `stribeck`.
    """
    low, high, winding = -params.coulomb_negative, params.coulomb_positive, params.winding * speed
    if params.rise > 0.0:
        grown = stribeck(params.rise, params.per_stribeck, speed)
        low, high = grown * low, grown * high
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
    """Joint torque (N m): `nu eta m` while the motor drives, `nu m / eta` when driven back (spec 03.2).

    Of a gear that turns, or is about to, forwards under a motor that pulls. One that may stand: `geared_step`.
    """
    if motor_torque * motor_speed >= 0.0:
        return params.ratio * params.efficiency * motor_torque
    return params.ratio * motor_torque / params.efficiency


@loop
def geared_step(
    friction: StictionParams, gear: GearParams, held: float, drive: float, speed: float
) -> tuple[float, float]:
    """Joint torque (N m) of a motor's torque less its shaft's friction through a gear, and what a rest is held by.

    What a gear loses is friction that grows with its load: of `m` at the gear, `(1 / eta + eta) / 2 m` less or more
    `(1 / eta - eta) / 2 |m|` arrives, which is `eta m` while the motor drives and `m / eta` when it is driven back. At
    standstill it is anything between, as `stiction_step` has it: the gear holds. `friction` must have been made for
    the gear's efficiency (`Friction.stiction`).
    """
    eta = gear.efficiency
    if eta == 1.0:
        rubbed, held = stiction_step(friction, held, speed)
        return gear.ratio * (drive - rubbed), held
    positive, negative, winding = friction.coulomb_positive, friction.coulomb_negative, friction.winding * speed
    if friction.rise > 0.0:
        grown = stribeck(friction.rise, friction.per_stribeck, speed)
        positive, negative = grown * positive, grown * negative
    mean, lost, push = 0.5 * (1.0 / eta + eta), 0.5 * (1.0 / eta - eta), drive - friction.viscous * speed
    high = mean * positive + lost * abs(push - positive)
    low = -mean * negative - lost * abs(push + negative)
    held = min(max(held + winding, low), high)
    return gear.ratio * (mean * push - min(max(held + winding, low), high)), held


@loop
def sliding_speed(speed: float, push: float, positive: float, negative: float, per_torque: float) -> float:
    """Speed after a step under a torque and Coulomb friction: it stops within the step where friction is enough.

    Exact for one inertia, that `per_torque` = dt / J belongs to; `positive` and `negative` are the magnitudes of
    Coulomb friction for the two directions. A shaft that stands under less than that keeps standing.
    """
    free = speed + per_torque * push
    if free > per_torque * positive:
        return free - per_torque * positive
    if free < -per_torque * negative:
        return free + per_torque * negative
    return 0.0
