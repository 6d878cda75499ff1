"""Inverse dynamics by the recursive Newton-Euler algorithm in link frames (Luh, Walker, Paul 1980; Siciliano 7.5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.rotors import reflected_inertia, rotor_reaction, spin_axis
from holonom.mechanics.equations.freedoms import FREEDOMS, Freedom
from holonom.mechanics.equations.kinematics import JointMotion, gather, joint_motion, split, spread
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matmul, matvec, scale, tvec
from holonom.model import ArmModel, Friction
from holonom.trace import Number, less, select

_Wrench = tuple[list[Number], list[Number]]
"""Force and moment."""

__all__ = ["coulomb_torque", "friction_slope", "friction_torque", "inverse_dynamics", "on_moving_base"]


def friction_torque(friction: Friction | None, qd: Number) -> Number:
    """Fv qd + Fs sgn(qd), with its own Coulomb torque for either direction; zero at rest."""
    if friction is None:
        return 0.0
    return friction.viscous * qd + coulomb_torque(friction, qd, qd)


def coulomb_torque(friction: Friction | None, qd: Number, slip: Number) -> Number:
    """Fs sgn(slip): Coulomb friction at the speed qd of a joint that slips, or is about to, in the direction of `slip`.

    Where the model states a Stribeck speed v_s, Fs grows towards rest by 1 + (ratio - 1) / (1 + (qd / v_s)^2) (Hess &
    Soom 1990).
    """
    if friction is None:
        return 0.0
    return _coulomb(friction, slip) * _stribeck(friction, qd)


def friction_slope(friction: Friction | None, qd: Number) -> Number:
    """Derivative of `friction_torque` by the speed, the jump at rest left out."""
    if friction is None:
        return 0.0
    if friction.stribeck_speed == 0.0:
        return friction.viscous
    part = _stribeck(friction, qd) - 1.0
    steep = -2.0 / ((friction.static_ratio - 1.0) * friction.stribeck_speed**2) if friction.static_ratio != 1.0 else 0.0
    return friction.viscous + _coulomb(friction, qd) * (part * part * qd * steep)


def _coulomb(friction: Friction, qd: Number) -> Number:
    backward = select(less(qd, 0.0), -friction.coulomb_negative, 0.0)
    return select(less(0.0, qd), friction.coulomb_positive, backward)


def _stribeck(friction: Friction, qd: Number) -> Number:
    if friction.stribeck_speed == 0.0:
        return 1.0
    x = qd * (1.0 / friction.stribeck_speed)
    return (friction.static_ratio - 1.0) / (x * x + 1.0) + 1.0


def _spin(w: Vector, wd: Vector) -> list[list[Number]]:
    """U = [wd]x + [w]x [w]x: the acceleration of a point fixed at r is a + U r."""
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return [
        [-(yy + zz), xy - wd[2], xz + wd[1]],
        [xy + wd[2], -(xx + zz), yz - wd[0]],
        [xz - wd[1], yz + wd[0], -(xx + yy)],
    ]


def _wrench_of_motion(body: Inertial, a: Vector, U: Sequence[Vector]) -> _Wrench:
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
    base = _base(model, model.gravity if gravity is None else gravity)
    return _forces(model, bodies, (q, qd, qdd), base, friction, wrench_tool)[0]


def on_moving_base(
    model: ArmModel,
    bodies: Sequence[Inertial],
    base_body: Inertial,
    motion: tuple[Vector, Vector, Vector],
    twist: Vector,
    acceleration: Vector,
    *,
    friction: bool = False,
) -> tuple[list[Number], list[Number]]:
    """Force and moment (6) that the base needs from outside, and joint torques, for a motion (q, qd, qdd) on it.

    `twist` [v; w] of the base and its rate, in the base's frame; gravity is to be taken off the linear rate.
    """
    v, w = twist[:3], twist[3:]
    wd, a = acceleration[3:], add(acceleration[:3], cross(w, v))
    state = _Motion(w, wd, a, _spin(w, wd))
    torque, (f, m) = _forces(model, bodies, motion, state, friction, None)
    own_f, own_m = _wrench_of_motion(base_body, state.a, state.U)
    return [*add(f, own_f), *add(m, own_m)], torque


def _forces(
    model: ArmModel,
    bodies: Sequence[Inertial],
    motion_of_joints: tuple[Vector, Vector, Vector],
    base: _Motion,
    friction: bool,
    wrench_tool: Vector | None,
) -> tuple[list[Number], _Wrench]:
    """Joint torques, and what the arm presses its base with: force and moment about its origin, in its frame."""
    q, qd, qdd = motion_of_joints
    motions = [joint_motion(j, q_i) for j, q_i in zip(model.joints, spread(model, q), strict=True)]
    states = [base]
    rates, accelerations = spread(model, qd, rates=True), spread(model, qdd, rates=True)
    for i, motion in enumerate(motions):
        freedom, carrier = FREEDOMS[model.joints[i].kind], states[model.parent(i) + 1]
        states.append(_outward(freedom, motion, carrier, rates[i], accelerations[i]))
    loads = [_wrench_of_motion(body, s.a, s.U) for body, s in zip(bodies, states[1:], strict=True)]
    if wrench_tool is not None:
        loads[model.tool_joint] = _sum(loads[model.tool_joint], _tool_load(model, wrench_tool))

    torque: list[Number] = [k * u for k, u in zip(reflected_inertia(model), accelerations, strict=True)]
    for i in range(len(motions)):
        if (spin := spin_axis(model, i)) is not None:
            p = model.parent(i)
            moment, torque_i = rotor_reaction(spin, rates[i], accelerations[i], states[p + 1].w, states[p + 1].wd)
            torque[i] = torque[i] + torque_i
            loads[p] = _sum(loads[p], ([0.0, 0.0, 0.0], moment))
    pressed: _Wrench = ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    for i in reversed(range(len(motions))):
        motion, (f, n) = motions[i], loads[i]
        at_joint = add(n, cross(add(motion.p_after, motion.slide), f))
        torque[i] = torque[i] + dot(motion.z_child, FREEDOMS[model.joints[i].kind].force(f, at_joint))
        f_parent = matvec(motion.R, f)
        inward = (f_parent, add(matvec(motion.R, at_joint), cross(motion.p_before, f_parent)))
        if (parent := model.parent(i)) >= 0:
            loads[parent] = _sum(loads[parent], inward)
        else:
            pressed = _sum(pressed, inward)
    if friction:
        torque = [t + friction_torque(j.friction, u) for t, j, u in zip(torque, model.joints, rates, strict=True)]
    return gather(model, torque), pressed


class _Motion(NamedTuple):
    """Angular velocity and its rate, acceleration of the origin (gravity as an acceleration), and U, in the frame."""

    w: Vector
    wd: Vector
    a: Vector
    U: Sequence[Vector]


def _base(model: ArmModel, gravity: Vector) -> _Motion:
    R_w0, _ = split(model.base)
    still = [0.0, 0.0, 0.0]
    return _Motion(still, still, tvec(R_w0, scale(-1.0, gravity)), [still] * 3)


def _outward(freedom: Freedom, motion: JointMotion, parent: _Motion, qd: Number, qdd: Number) -> _Motion:
    """Motion of a joint's frame from that of its parent."""
    R, z = motion.R, motion.z_child
    a = tvec(R, add(parent.a, matvec(parent.U, motion.p_before)))
    w, wd = tvec(R, parent.w), tvec(R, parent.wd)
    (turning, rate), drift = freedom.spin(z, qd, qdd, w), freedom.drift(z, qd, qdd, w)
    w, wd = add(w, turning), add(wd, rate)
    U = _spin(w, wd)
    return _Motion(w, wd, add(add(a, matvec(U, add(motion.p_after, motion.slide))), drift), U)


def _sum(a: _Wrench, b: _Wrench) -> _Wrench:
    return add(a[0], b[0]), add(a[1], b[1])


def _tool_load(model: ArmModel, wrench_tool: Vector) -> _Wrench:
    """The tool wrench as force and moment about the origin of the frame that carries the tool, in that frame."""
    R, p = split(model.tool)
    f = matvec(R, wrench_tool[:3])
    return f, add(matvec(R, wrench_tool[3:]), cross(p, f))
