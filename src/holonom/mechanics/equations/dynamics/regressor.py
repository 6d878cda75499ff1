"""The torque as a linear function of the arm's parameters: tau = Y(q, qd, qdd) pi (Siciliano 7.2.2; Atkeson 1986).

Column k is the inverse dynamics of an arm of which only parameter k is there, and is 1. The graph shares the motion
of the links between the columns, so the kernel is not ten times as long.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from holonom.mechanics.equations.dynamics.carried import accelerations, chain, of_body, power, wrench_of_motion
from holonom.mechanics.equations.dynamics.composite_body import MANY
from holonom.mechanics.equations.dynamics.inertia import Inertial, moved
from holonom.mechanics.equations.dynamics.newton_euler import inverse_dynamics
from holonom.mechanics.equations.kinematics import carrying, gather, spread
from holonom.mechanics.equations.vectors import Vector
from holonom.model import ArmModel, Motor
from holonom.trace import Number, less, select

__all__ = ["BODY_PARAMETERS", "DRIVE_PARAMETERS", "from_parameters", "regressor", "to_parameters"]

BODY_PARAMETERS = ("m", "hx", "hy", "hz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")
"""Mass, first moment m c and inertia about the link frame's origin, in the order that Pinocchio has."""

DRIVE_PARAMETERS = ("Ia", "Fv", "Fs+", "Fs-")
"""Reflected rotor inertia, viscous friction, Coulomb torque for positive and for negative speed."""


def from_parameters(p: Vector) -> Inertial:
    """Mass and moments from ten parameters: S = tr(I)/2 1 - I."""
    m, hx, hy, hz, xx, xy, yy, xz, yz, zz = p
    half = 0.5 * (xx + yy + zz)
    return Inertial(m, [hx, hy, hz], [[half - xx, -xy, -xz], [-xy, half - yy, -yz], [-xz, -yz, half - zz]])


def to_parameters(body: Inertial) -> list[Number]:
    """The ten parameters of a link, in the order of `BODY_PARAMETERS`."""
    I = body.rotational()
    return [body.m, *body.h, I[0][0], I[0][1], I[1][1], I[0][2], I[1][2], I[2][2]]


def regressor(model: ArmModel, q: Vector, qd: Vector, qdd: Vector) -> list[Number]:
    """Rows of Y (n, 14 N), N being the number of joints: ten columns per body, then four of drives per joint.

    The drives' columns come by quantity: all rotor inertias, all viscous frictions, all positive and all negative
    Coulomb torques (without Stribeck's rise at rest, which is not linear). Of the model's bodies and drives only gear
    ratios and motor axes are looked at, and those for rotors="full" only.
    """
    nothing = [from_parameters([0.0] * 10)] * len(model.joints)
    many = len(model.joints) >= MANY
    columns = [
        *(_columns_in_one_frame(model, q, qd, qdd) if many else _body_columns(model, nothing, q, qd, qdd)),
        *_rotor_columns(model, nothing, q, qd, qdd),
        *_friction_columns(model, qd),
    ]
    return [entry for row in zip(*columns, strict=True) for entry in row]


def _body_columns(
    model: ArmModel, nothing: list[Inertial], q: Vector, qd: Vector, qdd: Vector
) -> Iterator[list[Number]]:
    bare = _with_motor(model, None)
    for i in range(len(model.joints)):
        for unit in _unit_bodies():
            yield inverse_dynamics(bare, [*nothing[:i], unit, *nothing[i + 1 :]], q, qd, qdd)


def _columns_in_one_frame(model: ArmModel, q: Vector, qd: Vector, qdd: Vector) -> Iterator[list[Number]]:
    """The same for long chains, with fewer operations: S_j . f for each joint j that carries the body which f moves."""
    c = chain(model, q, qd)
    a = accelerations(c, spread(model, qd, rates=True), spread(model, qdd, rates=True))
    for i, (frame, v) in enumerate(zip(c.frames, c.velocity, strict=True)):
        carriers = carrying(model, i)
        for unit in _unit_bodies():
            f = wrench_of_motion(of_body(moved(unit, *frame), v), v, a[i + 1])
            yield gather(model, [power(S, f) if j in carriers else 0.0 for j, S in enumerate(c.axis)])


def _unit_bodies() -> list[Inertial]:
    """Bodies of which one parameter is 1 and all others are 0."""
    return [from_parameters([float(j == k) for j in range(10)]) for k in range(10)]


def _rotor_columns(
    model: ArmModel, nothing: list[Inertial], q: Vector, qd: Vector, qdd: Vector
) -> Iterator[list[Number]]:
    for i in range(len(model.joints)):
        yield inverse_dynamics(_with_motor(model, i), nothing, q, qd, qdd)


def _with_motor(model: ArmModel, only: int | None) -> ArmModel:
    """The arm without motors but one, whose reflected inertia is 1."""
    joints = [dataclasses.replace(joint, motor=None) for joint in model.joints]
    if only is None:
        return dataclasses.replace(model, joints=tuple(joints))
    stated = model.joints[only].motor
    motor = Motor(1.0, 1.0) if stated is None else dataclasses.replace(stated, rotor_inertia=stated.gear_ratio**-2)
    joints[only] = dataclasses.replace(joints[only], motor=motor)
    rotors = "reflected" if stated is None else model.rotors
    return dataclasses.replace(model, joints=tuple(joints), rotors=rotors)


def _friction_columns(model: ArmModel, qd: Vector) -> Iterator[list[Number]]:
    rates = spread(model, qd, rates=True)
    forward = [select(less(0.0, u), 1.0, 0.0) for u in rates]
    backward = [select(less(u, 0.0), -1.0, 0.0) for u in rates]
    for terms in (rates, forward, backward):
        for i, term in enumerate(terms):
            yield gather(model, [term if i == j else 0.0 for j in range(len(terms))])
