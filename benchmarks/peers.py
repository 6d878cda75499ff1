"""The same robots in peer libraries."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from holonom.mechanics import Arm
from holonom.model import ArmModel

__all__ = ["eaik_robot", "peer", "pinocchio_model"]


def peer(module: str) -> Any:
    """Return a peer library, None if it is not installed (extra "oracle")."""
    try:
        return importlib.import_module(module)
    except ImportError:
        return None


def pinocchio_model(pin: Any, arm: Arm) -> Any:
    """Build the arm in Pinocchio: same frames, bodies and reflected rotor inertias, no friction."""
    model = pin.Model()
    model.gravity.linear = np.array(arm.model.gravity)
    parent, placement = 0, pin.SE3(np.array(arm.model.base))
    assert arm.model.bodies is not None
    for k, (joint, body) in enumerate(zip(arm.model.joints, arm.model.bodies, strict=True)):
        kind = pin.JointModelRZ() if joint.kind == "revolute" else pin.JointModelPZ()
        parent = model.addJoint(parent, kind, placement * pin.SE3(np.array(joint.before)), joint.name)
        link = pin.SE3(np.array(joint.after))
        xx, yy, zz, xy, yz, xz = body.inertia
        inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        model.appendBodyToJoint(parent, pin.Inertia(body.mass, np.array(body.com), inertia), link)
        placement = link
        if joint.motor is not None:
            model.armature[k] = joint.motor.gear_ratio**2 * joint.motor.rotor_inertia
    model.addFrame(pin.Frame("tool", parent, 0, placement * pin.SE3(np.array(arm.model.tool)), pin.FrameType.OP_FRAME))
    return model


def eaik_robot(eaik: Any, model: ArmModel) -> tuple[Any, Any]:
    """EAIK's arm (module `eaik.IK_HP`) from the joint axes at q = 0, and the tool's rotation there.

    Ask it for `T` with `T[:3, :3] @ R_home.T` as the rotation.
    """
    T, axes, points = np.array(model.base), [], []
    for joint in model.joints:
        T = T @ np.array(joint.before)
        axes.append(T[:3, 2])
        points.append(T[:3, 3])
        T = T @ np.array(joint.after)
    tool = T @ np.array(model.tool)
    steps = np.diff([np.zeros(3), *points, tool[:3, 3]], axis=0)
    return eaik.HPRobot(np.array(axes), steps), tool[:3, :3]
