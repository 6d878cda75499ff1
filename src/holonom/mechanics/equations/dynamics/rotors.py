"""Spinning rotors of geared motors, carried by the link before their joint (Siciliano et al., Robotics, 7.1 and 7.2.2).

Rotor i turns with w_m = w_(i-1) + k qd_i z_m. Locked to its link it is part of that link; what the gear adds to the
kinetic energy is 1/2 k^2 I_m qd_i^2 ("reflected") and k I_m qd_i z_m . w_(i-1) ("full": coupling and gyroscopic terms).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from holonom.errors import ModelError
from holonom.mechanics.equations.dynamics.inertia import Inertial, fixed_to_body, from_body
from holonom.mechanics.equations.kinematics import JointMotion
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matvec, scale
from holonom.model import ArmModel, Body, Motor
from holonom.trace import Number

__all__ = ["links_with_rotors", "reflected_inertia", "rotor_coupling", "rotor_reaction", "spin_axis"]


def reflected_inertia(model: ArmModel) -> list[float]:
    """Rotor inertia seen at each joint, gear_ratio^2 I_m (specification 2.1, rotors="reflected")."""
    return [0.0 if j.motor is None else j.motor.gear_ratio**2 * j.motor.rotor_inertia for j in model.joints]


def links_with_rotors(model: ArmModel, bodies: Sequence[Body]) -> list[Inertial]:
    """Inertial parameters of the links, each with the locked rotors that it carries.

    Raises
    ------
    ModelError
        A rotor with a mass or inertia to add has no axis.
    """
    whole = list(bodies)
    if not model.links_include_rotors:
        for i, joint in enumerate(model.joints):
            if joint.motor is not None and model.parent(i) >= 0:
                rotor = _locked_rotor(joint.motor, _axis(model, i))
                whole[model.parent(i)] = fixed_to_body(whole[model.parent(i)], rotor)
    return [from_body(body) for body in whole]


def spin_axis(model: ArmModel, i: int) -> list[Number] | None:
    """k I_m z_m of the motor of joint i in the frame that carries it, if the model asks for it and it is not fixed."""
    motor = model.joints[i].motor
    if model.rotors != "full" or motor is None or model.parent(i) < 0:
        return None
    return scale(motor.gear_ratio * motor.rotor_inertia, _axis(model, i))


def rotor_reaction(spin: Vector, qd: Number, qdd: Number, w: Vector, wd: Vector) -> tuple[list[Number], Number]:
    """Moment that the link must give its rotor beyond the locked one's, and the torque that the joint adds.

    Both are rates of k I_m qd z_m and of k I_m z_m . w, for the link's angular velocity w and its rate, in its frame.
    """
    return add(scale(qdd, spin), scale(qd, cross(w, spin))), dot(spin, wd)


def rotor_coupling(model: ArmModel, motions: Sequence[JointMotion], i: int) -> Iterator[tuple[int, Number]]:
    """Entries B_ij of the full rotor model: k I_m z_m . z_j for each revolute j that carries the motor of joint i."""
    moment = spin_axis(model, i)
    j = model.parent(i)
    while moment is not None and j >= 0:
        if model.joints[j].turns:
            yield j, dot(motions[j].z_child, moment)
        moment = matvec(motions[j].R, moment)
        j = model.parent(j)


def _axis(model: ArmModel, i: int) -> tuple[float, float, float]:
    joint = model.joints[i]
    assert joint.motor is not None
    if joint.motor.axis is None:
        raise ModelError(
            f"arm {model.name!r}: the motor of joint {joint.name!r} states no axis, which rotors='full' and "
            "links_include_rotors=False need; give Motor(axis=...) in the frame that carries the joint"
        )
    return joint.motor.axis


def _locked_rotor(motor: Motor, z: tuple[float, float, float]) -> Body:
    """Mass at the motor's place; I_m about the axis, the transverse inertia about the others."""
    t, d = motor.transverse_inertia, motor.rotor_inertia - motor.transverse_inertia
    diagonal = (t + d * z[0] * z[0], t + d * z[1] * z[1], t + d * z[2] * z[2])
    return Body(motor.mass, motor.position, (*diagonal, d * z[0] * z[1], d * z[1] * z[2], d * z[0] * z[2]))
