"""Mass matrix by the composite rigid body algorithm (Walker & Orin 1982; Featherstone 2008, ch. 6)."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.dynamics.carried import Carried, Chain, carried, chain, inert, of_bodies, power
from holonom.mechanics.equations.dynamics.inertia import Inertial, merged, moved
from holonom.mechanics.equations.dynamics.rotors import reflected_inertia, rotor_coupling
from holonom.mechanics.equations.freedoms import FREEDOMS, Freedom
from holonom.mechanics.equations.kinematics import JointMotion, gather, joint_motion, spread
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matvec, scale, transpose
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["floating_mass_matrix", "independent", "joint_inertia", "mass_matrix", "with_rotors"]

MANY = 12
"""Joints from which on one common frame takes fewer operations."""


def mass_matrix(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[list[Number]]:
    """B(q), with the reflected rotor inertias on the diagonal.

    Short chains in link frames, where most of a robot's zeros are; long ones in one frame, where an entry costs less.
    """
    motions = [joint_motion(joint, q_i) for joint, q_i in zip(model.joints, spread(model, q), strict=True)]
    many = len(motions) >= MANY
    B = _in_one_frame(model, bodies, q) if many else _in_link_frames(model, bodies, motions)[0]
    for i in range(len(motions)):
        for j, coupling in rotor_coupling(model, motions, i):
            B[i][j] = B[j][i] = B[i][j] + coupling
    return independent(model, with_rotors(model, B))


def floating_mass_matrix(
    model: ArmModel, bodies: Sequence[Inertial], base_body: Inertial, q: Vector
) -> list[list[Number]]:
    """Inertia (6 + n, 6 + n) over the base's twist [v; w], in its frame, and the joints (Featherstone 2008, 9.4)."""
    motions = [joint_motion(joint, q_i) for joint, q_i in zip(model.joints, spread(model, q), strict=True)]
    B, columns, carried = _in_link_frames(model, bodies, motions)
    whole = merged(carried, base_body)
    coupling = transpose([gather(model, row) for row in transpose(columns)])
    own = independent(model, with_rotors(model, B))
    top = [[*row, *(c[k] for c in coupling)] for k, row in enumerate(_spatial(whole))]
    return top + [[*c, *row] for c, row in zip(coupling, own, strict=True)]


def _spatial(body: Inertial) -> list[list[Number]]:
    """The inertia (6, 6) that takes [v; w] to force and moment."""
    m, h, turning = body.m, body.h, body.rotational()
    H: list[list[Number]] = [[0.0, -h[2], h[1]], [h[2], 0.0, -h[0]], [-h[1], h[0], 0.0]]
    top = [[*(m if i == j else 0.0 for j in range(3)), *(-1.0 * x for x in H[i])] for i in range(3)]
    return top + [[*H[i], *turning[i]] for i in range(3)]


def with_rotors(model: ArmModel, B: list[list[Number]]) -> list[list[Number]]:
    """Add the reflected rotor inertias to an inertia over all joints."""
    for i, rotor in enumerate(reflected_inertia(model)):
        B[i][i] = B[i][i] + rotor
    return B


def _in_one_frame(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[list[Number]]:
    at_rest = chain(model, q, [0.0] * len(model.independent))
    return joint_inertia(at_rest, carried(model, of_bodies(at_rest, bodies)))


def joint_inertia(c: Chain, sums: Sequence[Carried]) -> list[list[Number]]:
    """Inertia over all joints without rotors: S_j . I S_i, I being what both carry."""
    n = len(c.axis)
    B: list[list[Number]] = [[0.0] * n for _ in range(n)]
    for i in range(n):
        f, j = inert(sums[i].inertia, c.axis[i]), i
        while j >= 0:
            B[i][j] = B[j][i] = power(c.axis[j], f)
            j = c.model.parent(j)
    return B


def _in_link_frames(
    model: ArmModel, bodies: Sequence[Inertial], motions: Sequence[JointMotion]
) -> tuple[list[list[Number]], list[list[Number]], Inertial]:
    """Inertia over all joints; force and moment on the base (6) for each joint's acceleration; all that it carries."""
    n = len(motions)
    on_base: list[list[Number]] = [[] for _ in range(n)]
    whole = Inertial(0.0, [0.0] * 3, [[0.0] * 3 for _ in range(3)])
    B: list[list[Number]] = [[0.0] * n for _ in range(n)]
    composite = list(bodies)
    for i in reversed(range(n)):
        f, m = _unit_wrench(FREEDOMS[model.joints[i].kind], motions[i], composite[i])
        j = i
        while j >= 0:
            here = motions[j]
            at_joint = add(m, cross(add(here.p_after, here.slide), f))
            B[i][j] = B[j][i] = dot(here.z_child, FREEDOMS[model.joints[j].kind].force(f, at_joint))
            f = matvec(here.R, f)
            m = add(matvec(here.R, at_joint), cross(here.p_before, f))
            j = model.parent(j)
        on_base[i] = [*f, *m]
        inward = moved(composite[i], motions[i].R, motions[i].p)
        if (parent := model.parent(i)) >= 0:
            composite[parent] = merged(composite[parent], inward)
        else:
            whole = merged(whole, inward)
    return B, on_base, whole


def _unit_wrench(freedom: Freedom, motion: JointMotion, body: Inertial) -> tuple[list[Number], list[Number]]:
    """Force and moment about the frame's origin that a unit acceleration of the joint takes for all that it carries."""
    w, v = freedom.twist(motion.z_child, motion.p_after)
    return (
        add(scale(body.m, v), cross(w, body.h)),
        add(matvec(body.rotational(), w), cross(body.h, v)),
    )


def independent(model: ArmModel, B: list[list[Number]]) -> list[list[Number]]:
    """G^T B G for any matrix over all joints, G being how they follow from the independent ones."""
    if len(model.independent) == len(B):
        return B
    half = [gather(model, row) for row in B]
    return transpose([gather(model, column) for column in transpose(half)])
