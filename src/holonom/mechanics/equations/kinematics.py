"""Forward kinematics and Jacobian of an arm (Siciliano et al., Robotics, 2.8 and 3.1)."""

from __future__ import annotations

from typing import NamedTuple

from holonom.mechanics.equations.freedoms import FREEDOMS
from holonom.mechanics.equations.vectors import (
    Pose,
    Vector,
    add,
    columns,
    compose,
    matmul,
    matvec,
    sub,
    tvec,
)
from holonom.model import ArmModel, Joint, Transform
from holonom.trace import Number

__all__ = [
    "JointMotion",
    "carrying",
    "flat_pose",
    "frames",
    "gather",
    "jacobian",
    "joint_motion",
    "pose",
    "split",
    "spread",
]


def split(T: Transform) -> Pose:
    """Return the rotation and position of a constant transform."""
    return [list(row[:3]) for row in T[:3]], [row[3] for row in T[:3]]


class JointMotion(NamedTuple):
    """The moving frame of a joint: `R`, `p` is T_(i-1)i; the joint axis in either frame; constant lever arms.

    The joint's own point lies at `p_before` in frame i-1; frame i's origin lies from there at `p_after` in frame i.
    """

    R: list[list[Number]]
    p: list[Number]
    z_child: list[Number]
    p_before: list[Number]
    p_after: list[Number]
    slide: list[Number]


def joint_motion(joint: Joint, q: Number) -> JointMotion:
    """T_(i-1)i = before Rot(z, q) after, or before Trans(z, q) after."""
    (Rb, pb), (Ra, pa) = split(joint.before), split(joint.after)
    z_child = list(Ra[2])  # Ra^T z
    Rz, way = FREEDOMS[joint.kind].displaced(q)
    turn = Rb if Rz is None else matmul(Rb, Rz)
    slide = [z * way for z in z_child]
    along = matvec(turn, [pa[0], pa[1], pa[2] + way])
    return JointMotion(matmul(turn, Ra), add(pb, along), z_child, list(pb), tvec(Ra, pa), slide)


def spread(model: ArmModel, q: Vector, *, rates: bool = False) -> list[Number]:
    """Values of all joints from the independent ones': a mimic's is multiplier * q + offset (a rate's has none)."""
    values: list[Number] = [0.0] * len(model.joints)
    for i, value in zip(model.independent, q, strict=True):
        values[i] = value
    for i, joint in enumerate(model.joints):
        if (follows := joint.mimic) is not None:
            values[i] = values[follows.joint] * follows.multiplier + (0.0 if rates else follows.offset)
    return values


def gather(model: ArmModel, values: Vector) -> list[Number]:
    """Generalised forces (or Jacobian entries) of the independent joints: the transpose of `spread`."""
    sums = list(values)
    for i, joint in enumerate(model.joints):
        if (follows := joint.mimic) is not None:
            sums[follows.joint] = sums[follows.joint] + values[i] * follows.multiplier
    return [sums[i] for i in model.independent]


def frames(model: ArmModel, q: Vector) -> list[Pose]:
    """T_w0, the frames of all joints T_w1, ..., T_wn, and T_wt."""
    poses = [split(model.base)]
    for i, (joint, value) in enumerate(zip(model.joints, spread(model, q), strict=True)):
        motion = joint_motion(joint, value)
        poses.append(compose(poses[model.parent(i) + 1], (motion.R, motion.p)))
    poses.append(compose(poses[model.tool_joint + 1], split(model.tool)))
    return poses


def flat_pose(T: Pose) -> list[Number]:
    """Rows of the 4x4 matrix."""
    R, p = T
    return [*R[0], p[0], *R[1], p[1], *R[2], p[2], 0.0, 0.0, 0.0, 1.0]


def pose(model: ArmModel, q: Vector, joint: int | None, offset: Pose | None = None) -> list[Number]:
    """Rows of T_w(joint number) @ offset; -1 is the base, None the tool."""
    found = frames(model, q)
    T = found[-1] if joint is None else found[joint + 1]
    return flat_pose(T if offset is None else compose(T, offset))


def carrying(model: ArmModel, joint: int) -> set[int]:
    """Numbers of the joints between the base and a joint's frame, that joint included."""
    path = set()
    while joint >= 0:
        path.add(joint)
        joint = model.parent(joint)
    return path


def jacobian(
    model: ArmModel, q: Vector, expressed_in: str, joint: int | None = None, offset: Pose | None = None
) -> list[Number]:
    """Rows of the geometric Jacobian (6, n) of a frame's origin, [v; w], in the world, base, tool or its own frame.

    The frame is as in `pose`, the tool unless given. Column i: revolute [z x (p - p_i); z], prismatic [z; 0]
    (specification 1.4); 0 where the joint does not carry the frame.
    """
    T = frames(model, q)
    carrier = model.tool_joint if joint is None else joint
    own = T[-1] if joint is None else T[joint + 1]
    R_own, p_own = own if offset is None else compose(own, offset)
    R_from = {"world": None, "base": T[0][0], "tool": T[-1][0], "own": R_own}[expressed_in]
    path = carrying(model, carrier)
    columns_: list[list[Number]] = []
    for i, link in enumerate(model.joints):
        R, p = T[model.parent(i) + 1]
        Rb, pb = split(link.before)
        z = columns(matmul(R, Rb))[2]
        v: Vector = [0.0] * 3
        w: Vector = [0.0] * 3
        if i in path:
            w, v = FREEDOMS[link.kind].twist(z, sub(p_own, add(p, matvec(R, pb))))
        if R_from is not None:
            v, w = tvec(R_from, v), tvec(R_from, w)
        columns_.append([*v, *w])
    return [entry for row in range(6) for entry in gather(model, [column[row] for column in columns_])]
