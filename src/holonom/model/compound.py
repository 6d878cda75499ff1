"""Joints of several freedoms as joints of one freedom each, in a row."""

from __future__ import annotations

import numpy as np

from holonom.arrays import Array
from holonom.model.arm import Joint, constant_transform
from holonom.model.joint_kinds import kind_of
from holonom.model.limits import JointLimits

__all__ = ["frame_along", "joints_of"]

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def frame_along(axis: tuple[float, float, float]) -> Array:
    """A rotation (4, 4) that takes z to the axis; for an axis along x, y or z it only permutes and flips."""
    T = np.eye(4)
    z = np.array(axis)
    if axis != (0.0, 0.0, 1.0):
        x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
        x /= np.linalg.norm(x)
        T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return T


def joints_of(
    name: str, kind: str, before: Array, after: Array, *, number: int, parent: int, limits: JointLimits = JointLimits()
) -> list[Joint]:
    """What a joint of any kind is made of: `before @ motion @ after` from joint `parent` on.

    Parameters
    ----------
    before, after : (4, 4), constant; z of the frame between is the axis, of a planar joint the normal of its plane.
    number : of the first one among all joints of the model; those after it follow in order, each on the one before.
    limits : of each.

    Returns
    -------
    None at all, an empty list, for kinds without a place in q (fixed, floating). Links between the joints have no mass.
    """
    parts = kind_of(kind).made_of
    joints = []
    for k, (suffix, single, axis) in enumerate(parts):
        A = frame_along(AXES[axis])
        joints.append(
            Joint(
                f"{name}{suffix}",
                single,
                before=constant_transform(before @ A if k == 0 else A),
                after=constant_transform(A.T @ after if k == len(parts) - 1 else A.T),
                limits=limits,
                parent=parent if k == 0 else number + k - 1,
            )
        )
    return joints
