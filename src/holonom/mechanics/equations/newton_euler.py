"""Inverse dynamics by the recursive Newton-Euler algorithm in link frames (Luh, Walker, Paul 1980; Siciliano 7.5)."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.inertia import Inertial
from holonom.mechanics.equations.kinematics import JointMotion, joint_motion, split
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matmul, matvec, scale, tvec
from holonom.model import ArmModel, Friction
from holonom.trace import Number, less, select

__all__ = ["friction_torque", "inverse_dynamics", "reflected_inertia"]


def reflected_inertia(model: ArmModel) -> list[float]:
    """Rotor inertia seen at each joint, gear_ratio^2 I_m (specification 2.1, rotors="reflected")."""
    return [0.0 if j.motor is None else j.motor.gear_ratio**2 * j.motor.rotor_inertia for j in model.joints]


def friction_torque(friction: Friction | None, qd: Number) -> Number:
    """Fv qd + Fs sgn(qd), with its own Coulomb torque for either direction; zero at rest."""
    if friction is None:
        return 0.0
    backward = select(less(qd, 0.0), -friction.coulomb_negative, 0.0)
    return friction.viscous * qd + select(less(0.0, qd), friction.coulomb_positive, backward)


def _spin(w: Vector, wd: Vector) -> list[list[Number]]:
    """U = [wd]x + [w]x [w]x: the acceleration of a point fixed at r is a + U r."""
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return [
        [-(yy + zz), xy - wd[2], xz + wd[1]],
        [xy + wd[2], -(xx + zz), yz - wd[0]],
        [xz - wd[1], yz + wd[0], -(xx + yy)],
    ]


def _wrench_of_motion(body: Inertial, a: Vector, U: Sequence[Vector]) -> tuple[list[Number], list[Number]]:
    """Force and moment about the frame origin that move a body: F = m a + U h, N = vee(U S - (U S)^T) + h x a."""
    US = matmul(U, body.S)
    turn: list[Number] = [US[2][1] - US[1][2], US[0][2] - US[2][0], US[1][0] - US[0][1]]
    return add(scale(body.m, a), matvec(U, body.h)), add(turn, cross(body.h, a))


def inverse_dynamics(
    model: ArmModel,
    bodies: Sequence[Inertial],
    q: Vector,
    qd: Vector,
    qdd: Vector,
    *,
    gravity: Vector | None = None,
    friction: bool = False,
    wrench_tool: Vector | None = None,
) -> list[Number]:
    """Joint torques for a motion.

    `wrench_tool` [f; m] is what the arm exerts on its environment at the tool point, in the tool frame.
    """
    R_w0, _ = split(model.base)
    g = model.gravity if gravity is None else gravity
    w: Vector = [0.0, 0.0, 0.0]
    wd: Vector = [0.0, 0.0, 0.0]
    a: Vector = tvec(R_w0, scale(-1.0, g))
    U: Sequence[Vector] = [[0.0] * 3] * 3
    motions: list[JointMotion] = []
    loads: list[tuple[list[Number], list[Number]]] = []
    for joint, body, q_i, qd_i, qdd_i in zip(model.joints, bodies, q, qd, qdd, strict=True):
        motion = joint_motion(joint, q_i)
        R, z = motion.R, motion.z_child
        a_point = tvec(R, add(a, matvec(U, motion.p_before)))
        w, wd = tvec(R, w), tvec(R, wd)
        if joint.kind == "revolute":
            wd = add(add(wd, scale(qdd_i, z)), cross(w, scale(qd_i, z)))
            w = add(w, scale(qd_i, z))
            U = _spin(w, wd)
            a = add(a_point, matvec(U, motion.p_after))
        else:
            U = _spin(w, wd)
            a = add(a_point, matvec(U, add(motion.p_after, motion.slide)))
            a = add(a, add(scale(qdd_i, z), scale(2.0, cross(w, scale(qd_i, z)))))
        motions.append(motion)
        loads.append(_wrench_of_motion(body, a, U))

    f, n = _tool_load(model, wrench_tool)
    torque: list[Number] = []
    for i in reversed(range(len(motions))):
        joint, motion = model.joints[i], motions[i]
        F, N = loads[i]
        f, n = add(f, F), add(n, N)
        at_joint = add(n, cross(add(motion.p_after, motion.slide), f))
        torque.append(dot(motion.z_child, at_joint if joint.kind == "revolute" else f))
        f = matvec(motion.R, f)
        n = add(matvec(motion.R, at_joint), cross(motion.p_before, f))
    torque.reverse()
    rotor = reflected_inertia(model)
    torque = [t + k * u for t, k, u in zip(torque, rotor, qdd, strict=True)]
    if friction:
        torque = [t + friction_torque(j.friction, u) for t, j, u in zip(torque, model.joints, qd, strict=True)]
    return torque


def _tool_load(model: ArmModel, wrench_tool: Vector | None) -> tuple[list[Number], list[Number]]:
    """The tool wrench as force and moment about the last link frame's origin, in that frame."""
    if wrench_tool is None:
        return [0.0] * 3, [0.0] * 3
    R, p = split(model.tool)
    f = matvec(R, wrench_tool[:3])
    return f, add(matvec(R, wrench_tool[3:]), cross(p, f))
