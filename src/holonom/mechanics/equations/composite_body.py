"""Mass matrix by the composite rigid body algorithm (Walker & Orin 1982; Featherstone 2008, ch. 6)."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.inertia import Inertial, merged, moved
from holonom.mechanics.equations.kinematics import JointMotion, gather, joint_motion, spread
from holonom.mechanics.equations.rotors import reflected_inertia, rotor_coupling
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matvec, scale, transpose
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["independent", "mass_matrix"]


def mass_matrix(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[list[Number]]:
    """B(q), with the reflected rotor inertias on the diagonal."""
    n = len(model.joints)
    motions = [joint_motion(joint, q_i) for joint, q_i in zip(model.joints, spread(model, q), strict=True)]
    B: list[list[Number]] = [[0.0] * n for _ in range(n)]
    rotor = reflected_inertia(model)
    composite = list(bodies)
    for i in reversed(range(n)):
        f, m = _unit_wrench(model.joints[i].kind, motions[i], composite[i])
        j = i
        while j >= 0:
            here = motions[j]
            at_joint = add(m, cross(add(here.p_after, here.slide), f))
            B[i][j] = B[j][i] = dot(here.z_child, at_joint if model.joints[j].kind == "revolute" else f)
            f = matvec(here.R, f)
            m = add(matvec(here.R, at_joint), cross(here.p_before, f))
            j = model.parent(j)
        B[i][i] = B[i][i] + rotor[i]
        for j, coupling in rotor_coupling(model, motions, i):
            B[i][j] = B[j][i] = B[i][j] + coupling
        if (parent := model.parent(i)) >= 0:
            composite[parent] = merged(composite[parent], moved(composite[i], motions[i].R, motions[i].p))
    return independent(model, B)


def _unit_wrench(kind: str, motion: JointMotion, body: Inertial) -> tuple[list[Number], list[Number]]:
    """Force and moment about the frame's origin that a unit acceleration of the joint takes for all that it carries."""
    if kind == "prismatic":
        return scale(body.m, motion.z_child), cross(body.h, motion.z_child)
    spin = motion.z_child
    a = cross(spin, motion.p_after)
    return (
        add(scale(body.m, a), cross(spin, body.h)),
        add(matvec(body.rotational(), spin), cross(body.h, a)),
    )


def independent(model: ArmModel, B: list[list[Number]]) -> list[list[Number]]:
    """G^T B G for any matrix over all joints, G being how they follow from the independent ones."""
    if len(model.independent) == len(B):
        return B
    half = [gather(model, row) for row in B]
    return transpose([gather(model, column) for column in transpose(half)])
