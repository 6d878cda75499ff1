"""What each joint carries, summed in one frame: inertia, momentum and the operator of the Coriolis forces.

The frame is that of the first joint (its axis is z, its point the origin): what hangs on it needs the fewest rotations,
and sums over bodies are plain sums. Twists and wrenches are Featherstone's (Rigid Body Dynamics Algorithms, ch. 2).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

from holonom.mechanics.equations.dynamics.inertia import Inertial, merged, moved
from holonom.mechanics.equations.freedoms import FREEDOMS
from holonom.mechanics.equations.kinematics import joint_motion, split, spread
from holonom.mechanics.equations.vectors import (
    Matrix,
    Pose,
    Vector,
    add,
    columns,
    compose,
    cross,
    dot,
    matvec,
    scale,
    transpose,
    tvec,
)
from holonom.model import ArmModel, constant_transform
from holonom.trace import Number

__all__ = [
    "Carried",
    "Chain",
    "Twist",
    "accelerations",
    "carried",
    "chain",
    "coriolis",
    "coriolis_transposed",
    "in_motion",
    "inert",
    "moving",
    "of_bodies",
    "of_body",
    "plus",
    "power",
    "times",
    "wrench_of_motion",
]

IDENTITY = constant_transform(((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)))


class Twist(NamedTuple):
    """Angular part and the linear part at the origin; a wrench likewise: moment about the origin, then force."""

    w: Vector
    v: Vector


STILL = Twist([0.0, 0.0, 0.0], [0.0, 0.0, 0.0])


def plus(a: Twist, b: Twist) -> Twist:
    """a + b."""
    return Twist(add(a.w, b.w), add(a.v, b.v))


def times(k: Number, a: Twist) -> Twist:
    """k a."""
    return Twist(scale(k, a.w), scale(k, a.v))


def moving(a: Twist, b: Twist) -> Twist:
    """a x b: the rate of a twist b that is fixed to a body which moves with a."""
    return Twist(cross(a.w, b.w), add(cross(a.w, b.v), cross(a.v, b.w)))


def power(a: Twist, f: Twist) -> Number:
    """Power of a wrench f along a twist a."""
    return dot(a.w, f.w) + dot(a.v, f.v)


class Chain(NamedTuple):
    """Geometry and velocities of all joints, in the frame of the first one.

    `frames[i]` is the pose of joint i's frame; `axis[i]` the joint's twist S; `carrier[i]` the velocity of what carries
    the joint and `velocity[i]` that of its own frame; `axis_rate[i]` = carrier x S; `up` minus the gravity.
    """

    model: ArmModel
    frames: list[Pose]
    axis: list[Twist]
    axis_rate: list[Twist]
    carrier: list[Twist]
    velocity: list[Twist]
    up: Vector


def chain(model: ArmModel, q: Vector, qd: Vector) -> Chain:
    """Geometry and velocities; q and qd are those of the independent joints."""
    values, rates = spread(model, q), spread(model, qd, rates=True)
    bare = joint_motion(dataclasses.replace(model.joints[0], after=IDENTITY), values[0])
    base: Pose = transpose(bare.R), scale(-1.0, tvec(bare.R, bare.p))
    up = matvec(base[0], tvec(split(model.base)[0], scale(-1.0, model.gravity)))
    frames, axes = list[Pose](), list[Twist]()
    for i, joint in enumerate(model.joints):
        parent = model.parent(i)
        on = frames[parent] if parent >= 0 else base
        motion = joint_motion(joint, values[i])
        R, point = compose(on, split(joint.before)) if i else split(IDENTITY)
        z = columns(R)[2]
        axes.append(Twist(*FREEDOMS[joint.kind].twist(z, scale(-1.0, point))))
        frames.append(compose(on, (motion.R, motion.p)) if i else split(joint.after))
    return in_motion(model, frames, axes, up, rates)


def in_motion(model: ArmModel, frames: list[Pose], axes: list[Twist], up: Vector, rates: Vector) -> Chain:
    """Velocities of all joints, given where they are."""
    found = Chain(model, frames, axes, [], [], [], up)
    for i, axis in enumerate(axes):
        parent = model.parent(i)
        carrier = found.velocity[parent] if parent >= 0 else STILL
        found.axis_rate.append(moving(carrier, axis))
        found.carrier.append(carrier)
        found.velocity.append(plus(carrier, times(rates[i], axis)))
    return found


def accelerations(c: Chain, rates: Vector, joint: Vector) -> list[Twist]:
    """Spatial accelerations of the base (first) and all frames: a + S qdd + S' qd; gravity is one of the base."""
    found = [Twist(STILL.w, c.up)]
    for i, (qd, qdd) in enumerate(zip(rates, joint, strict=True)):
        own = plus(times(qdd, c.axis[i]), times(qd, c.axis_rate[i]))
        found.append(plus(found[c.model.parent(i) + 1], own))
    return found


class Carried(NamedTuple):
    """Sums over bodies: inertia, momentum P, and K = tr(W) 1 - W with W = sum of m r' r^T."""

    inertia: Inertial
    P: Vector
    K: Matrix


def of_bodies(c: Chain, bodies: Sequence[Inertial]) -> list[Carried]:
    """Each body by itself."""
    return [of_body(moved(b, *T), v) for b, T, v in zip(bodies, c.frames, c.velocity, strict=True)]


def of_body(body: Inertial, velocity: Twist) -> Carried:
    """A body that is stated in the common frame."""
    S = [[body.S[min(i, j)][max(i, j)] for j in range(3)] for i in range(3)]  # one of two equal expressions
    w, v = velocity
    W = columns([add(cross(w, column), scale(h, v)) for column, h in zip(S, body.h, strict=True)])
    K = [[W[1][1] + W[2][2] if i == j == 0 else -W[i][j] for j in range(3)] for i in range(3)]
    K[1][1], K[2][2] = W[0][0] + W[2][2], W[0][0] + W[1][1]
    return Carried(Inertial(body.m, body.h, S), add(scale(body.m, v), cross(w, body.h)), K)


def carried(model: ArmModel, each: Sequence[Carried]) -> list[Carried]:
    """All that each joint carries."""
    sums = list(each)
    for i in reversed(range(len(sums))):
        if (parent := model.parent(i)) >= 0:
            a, b = sums[parent], sums[i]
            K = [add(x, y) for x, y in zip(a.K, b.K, strict=True)]
            sums[parent] = Carried(merged(a.inertia, b.inertia), add(a.P, b.P), K)
    return sums


def inert(body: Inertial, a: Twist) -> Twist:
    """I a: the momentum of a velocity, or the wrench of an acceleration."""
    return Twist(add(matvec(body.rotational(), a.w), cross(body.h, a.v)), add(scale(body.m, a.v), cross(a.w, body.h)))


def wrench_of_motion(body: Carried, v: Twist, a: Twist) -> Twist:
    """Wrench that moves a body: I a + v x* I v."""
    momentum = inert(body.inertia, v)
    gyroscopic = Twist(add(cross(v.w, momentum.w), cross(v.v, body.P)), cross(v.w, body.P))
    return plus(inert(body.inertia, a), gyroscopic)


def coriolis(sums: Carried, a: Twist) -> Twist:
    """B a, 2 B = v x* I - I v x + (I v) x-bar* (Echeandia & Wensing 2021): only the angular part of a counts."""
    return Twist(matvec(sums.K, a.w), cross(a.w, sums.P))


def coriolis_transposed(sums: Carried, a: Twist) -> list[Number]:
    """B^T a: a pure moment."""
    return add(tvec(sums.K, a.w), cross(sums.P, a.v))
