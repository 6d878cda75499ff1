"""The same robots in peer libraries."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from holonom.mechanics import Arm
from holonom.mobile import BaseDrive, WheelBase
from holonom.model import ArmModel

__all__ = ["eaik_robot", "mujoco_base", "peer", "pinocchio_model"]


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


def mujoco_base(base: WheelBase, drive: BaseDrive, friction: float, dt: float) -> str:
    """A base on fixed wheels and passive balls as MJCF, steps of dt, s: same mass, motors and contacts.

    The motors' windings follow at once; a wheel touches the floor in a point, as a sphere that turns about its axle;
    what it weighs is in the body, its inertia with the geared rotor in the joint.
    """
    motor, N = drive.motor, drive.gear.ratio
    gain = N * motor.torque_constant / motor.resistance
    r, (cx, cy) = float(base.wheel_radii[0]), base.com.tolist()
    inertia = " ".join(f"{v:.17g}" for v in np.diag(base.inertia))
    wheels, actuators = "", ""
    for k, wheel in enumerate(base.wheels):
        if not wheel.driven:
            wheels += (
                f'<geom type="sphere" size="{wheel.radius}" pos="{wheel.x} {wheel.y} {wheel.radius - r}" condim="1" '
                'priority="1" mass="0"/>'
            )
            continue
        wheels += (
            f'<body pos="{wheel.x} {wheel.y} 0"><joint name="wheel{k}" axis="0 1 0" armature="{drive.inertia}"/>'
            f'<inertial pos="0 0 0" mass="1e-4" diaginertia="1e-8 1e-8 1e-8"/><geom type="sphere" size="{r}"/></body>'
        )
        actuators += (
            f'<general joint="wheel{k}" gainprm="{gain}" biastype="affine" '
            f'biasprm="0 0 {-gain * N * motor.back_emf_constant}"/>'
        )
    return (
        f'<mujoco><option timestep="{dt}" integrator="implicitfast" cone="elliptic" impratio="100"/><worldbody>'
        f'<geom type="plane" size="50 50 1" friction="{friction}"/><body pos="0 0 {r}"><freejoint/>'
        f'<inertial pos="{cx} {cy} {base.com_height - r}" mass="{base.mass}" diaginertia="{inertia}"/>{wheels}</body>'
        f"</worldbody><actuator>{actuators}</actuator></mujoco>"
    )


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
