"""Forward kinematics and Jacobian of a serial arm (Siciliano et al., Robotics, 2.8 and 3.1)."""

from __future__ import annotations

from typing import NamedTuple

from holonom.mechanics.equations.vectors import (
    Pose,
    Vector,
    add,
    columns,
    compose,
    cross,
    matmul,
    matvec,
    sub,
    tvec,
)
from holonom.model import ArmModel, Joint, Transform
from holonom.trace import Number, cos, sin

__all__ = ["JointMotion", "flat_pose", "frames", "jacobian", "joint_motion", "pose", "split"]


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
    if joint.kind == "revolute":
        c, s = cos(q), sin(q)
        Rz: list[list[Number]] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        turn = matmul(Rb, Rz)
        p = add(pb, matvec(turn, pa))
        return JointMotion(matmul(turn, Ra), p, z_child, list(pb), tvec(Ra, pa), [0.0, 0.0, 0.0])
    slide = [z * q for z in z_child]
    along = matvec(Rb, [pa[0], pa[1], pa[2] + q])
    return JointMotion(matmul(Rb, Ra), add(pb, along), z_child, list(pb), tvec(Ra, pa), slide)


def frames(model: ArmModel, q: Vector) -> list[Pose]:
    """T_w0, T_w1, ..., T_wn, T_wt."""
    poses = [split(model.base)]
    for joint, q_i in zip(model.joints, q, strict=True):
        motion = joint_motion(joint, q_i)
        poses.append(compose(poses[-1], (motion.R, motion.p)))
    poses.append(compose(poses[-1], split(model.tool)))
    return poses


def flat_pose(T: Pose) -> list[Number]:
    """Rows of the 4x4 matrix."""
    R, p = T
    return [*R[0], p[0], *R[1], p[1], *R[2], p[2], 0.0, 0.0, 0.0, 1.0]


def pose(model: ArmModel, q: Vector, frame: int) -> list[Number]:
    """Rows of T_w(frame); frame 0 .. n, n + 1 is the tool."""
    return flat_pose(frames(model, q)[frame])


def jacobian(model: ArmModel, q: Vector, expressed_in: str) -> list[Number]:
    """Rows of the geometric Jacobian (6, n) of the tool point, [v; w], in the world or the tool frame.

    Column i: revolute [z x (p - p_i); z], prismatic [z; 0] (specification 1.4).
    """
    T = frames(model, q)
    R_tool, p_tool = T[-1]
    columns_: list[list[Number]] = []
    for joint, (R, p) in zip(model.joints, T, strict=False):
        Rb, pb = split(joint.before)
        z = columns(matmul(R, Rb))[2]
        point = add(p, matvec(R, pb))
        if joint.kind == "revolute":
            v, w = cross(z, sub(p_tool, point)), z
        else:
            v, w = z, [0.0, 0.0, 0.0]
        if expressed_in == "tool":
            v, w = tvec(R_tool, v), tvec(R_tool, w)
        columns_.append([*v, *w])
    return [column[row] for row in range(6) for column in columns_]
