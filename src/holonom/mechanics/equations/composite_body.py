"""Mass matrix by the composite rigid body algorithm (Walker & Orin 1982; Featherstone 2008, ch. 6)."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.inertia import Inertial, merged, moved
from holonom.mechanics.equations.kinematics import joint_motion
from holonom.mechanics.equations.newton_euler import reflected_inertia
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matvec, scale
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["mass_matrix"]


def mass_matrix(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[list[Number]]:
    """B(q), with the reflected rotor inertias on the diagonal."""
    n = len(model.joints)
    motions = [joint_motion(joint, q_i) for joint, q_i in zip(model.joints, q, strict=True)]
    B: list[list[Number]] = [[0.0] * n for _ in range(n)]
    rotor = reflected_inertia(model)
    composite = bodies[-1]
    for i in reversed(range(n)):
        motion = motions[i]
        # Unit acceleration of joint i moves everything beyond it: the wrench that this takes, about frame i's origin.
        lever = add(motion.p_after, motion.slide)
        if model.joints[i].kind == "revolute":
            spin = motion.z_child
            a = cross(spin, lever)
            f = add(scale(composite.m, a), cross(spin, composite.h))
            m = add(matvec(composite.rotational(), spin), cross(composite.h, a))
        else:
            f = scale(composite.m, motion.z_child)
            m = cross(composite.h, motion.z_child)
        for j in reversed(range(i + 1)):
            here = motions[j]
            at_joint = add(m, cross(add(here.p_after, here.slide), f))
            B[i][j] = B[j][i] = dot(here.z_child, at_joint if model.joints[j].kind == "revolute" else f)
            f = matvec(here.R, f)
            m = add(matvec(here.R, at_joint), cross(here.p_before, f))
        B[i][i] = B[i][i] + rotor[i]
        if i > 0:
            composite = merged(bodies[i - 1], moved(composite, motion.R, motion.p))
    return B
