"""Arms of every family that has a closed-form inverse, with random lengths and twists."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from arms import random_pose
from scipy.spatial.transform import Rotation

from holonom.mechanics import Arm, arm_from_dh
from holonom.mechanics.equations import kinematics
from holonom.mechanics.kernels.inverse.closed_form import ClosedForm, closed_form
from holonom.mechanics.kernels.inverse.geometry import inverse_geometry
from holonom.model import ArmModel, DHRow, Joint, JointLimits, arm_model_from_dh, constant_transform, preset

ANY = None
FAMILIES = {  # twists in degrees, lengths a, offsets d (ANY: random), kinds; all standard DH
    "2 parallel to 3": ((ANY, 0, ANY, ANY, ANY, ANY), (ANY, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, ANY), "RRRRRR"),
    "2 against 3": ((90, 180, 90, -90, 90, 0), (ANY, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, ANY), "RRRRRR"),
    "1 parallel to 2": ((0, ANY, ANY, ANY, ANY, ANY), (ANY, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, 0), "RRRRRR"),
    "1 meets 2": ((ANY, ANY, ANY, ANY, ANY, ANY), (0, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, ANY), "RRRRRR"),
    "2 meets 3": ((ANY, ANY, ANY, ANY, ANY, ANY), (ANY, 0, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, ANY), "RRRRRR"),
    "3 slides": ((ANY, ANY, ANY, ANY, ANY, ANY), (0, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, 0, 0, ANY), "RRPRRR"),
    "scara, wrist": ((0, 180, ANY, ANY, ANY, 0), (ANY, ANY, ANY, 0, 0, 0), (ANY, ANY, 0, ANY, 0, ANY), "RRPRRR"),
    "1 slides": ((ANY, 0, ANY, ANY, ANY, ANY), (ANY, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, ANY), "PRRRRR"),
    "any spherical wrist": ((ANY,) * 6, (ANY, ANY, ANY, 0, 0, 0), (ANY, ANY, ANY, ANY, 0, ANY), "RRRRRR"),
    "any three joints": ((ANY,) * 3, (ANY,) * 3, (ANY,) * 3, "RRR"),
    "three parallel": ((ANY, 0, 0, ANY, ANY, ANY), (ANY, ANY, ANY, ANY, 0, 0), (ANY,) * 6, "RRRRRR"),
    "three parallel, one against": ((90, 180, 0, 90, -90, 0), (0, ANY, ANY, 0, 0, 0), (ANY,) * 6, "RRRRRR"),
    "scara": ((0, 180, 0, 0), (ANY, ANY, 0, 0), (ANY, ANY, 0, ANY), "RRPR"),
    "scara, slide last": ((0, 180, 0, ANY), (ANY, ANY, ANY, ANY), (ANY, ANY, ANY, 0), "RRRP"),
    "planar 3R": ((0, 180, 0), (ANY, ANY, ANY), (ANY, ANY, ANY), "RRR"),
    "planar 2R": ((0, 0), (ANY, ANY), (ANY, ANY), "RR"),
    "three joints": ((90, 0, 0), (ANY, ANY, ANY), (ANY, ANY, ANY), "RRR"),
    "three joints, 1 meets 2": ((ANY, ANY, 0), (0, ANY, ANY), (ANY, ANY, ANY), "RRR"),
}


def family_model(name: str, seed: int, limits: JointLimits = JointLimits()) -> ArmModel:
    """A random arm of a family, with a random base and tool."""
    rng = np.random.default_rng([seed, *name.encode()])
    twists, lengths, offsets, kinds = FAMILIES[name]
    rows = [
        DHRow(
            a=rng.uniform(0.1, 0.5) if a is ANY else a,
            alpha=math.radians(rng.choice([-1, 1]) * rng.uniform(40, 140) if alpha is ANY else alpha),
            d=rng.uniform(-0.4, 0.4) if d is ANY else d,
            theta=rng.uniform(-3, 3),
            kind="revolute" if kind == "R" else "prismatic",
        )
        for alpha, a, d, kind in zip(twists, lengths, offsets, kinds, strict=True)
    ]
    model = arm_model_from_dh(rows, convention="standard", name=name, limits=[limits] * len(rows))
    base, tool = constant_transform(random_pose(rng)), constant_transform(random_pose(rng))
    return dataclasses.replace(model, base=base, tool=tool)


def backwards(model: ArmModel) -> ArmModel:
    """The same arm, held at its tool: frames turned over so that q keeps its sense."""
    over = np.diag([1.0, -1.0, -1.0, 1.0])
    joints = []
    for joint in reversed(model.joints):
        before, after = np.linalg.inv(joint.after) @ over, over @ np.linalg.inv(joint.before)
        joints.append(Joint(joint.name, joint.kind, constant_transform(before), constant_transform(after)))
    return ArmModel(f"{model.name}, backwards", tuple(joints))


def fk(model: ArmModel, q: np.ndarray) -> np.ndarray:
    """T_wt by the float form."""
    return np.array(kinematics.pose(model, [float(v) for v in q], None), dtype=float).reshape(4, 4)


def form_of(model: ArmModel) -> ClosedForm:
    form = closed_form(model)
    assert form is not None
    return form


def solve(model: ArmModel, T: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All branches (k, n) and their status by the float form."""
    form = form_of(model)
    target = T.reshape(-1) if form.task == "pose" else T[:3, 3]
    q, status = inverse_geometry(model, form, [float(v) for v in target])
    return np.array(q, dtype=float).reshape(len(form.names), -1), np.array(status)


def miss(model: ArmModel, q: np.ndarray, T: np.ndarray) -> float:
    """How far a joint vector misses a target."""
    apart = fk(model, q) - T
    return float(np.abs(apart if form_of(model).task == "pose" else apart[:3, 3]).max())


def apart(model: ArmModel, q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Largest joint difference (...), whole turns aside."""
    turning = np.array([joint.kind == "revolute" for joint in model.joints])
    difference = q - other
    return np.abs(np.where(turning, (difference + np.pi) % (2 * np.pi) - np.pi, difference)).max(-1)


def three_joint() -> Arm:
    """A waist, a shoulder and an elbow: it places points."""
    return arm_from_dh([DHRow(alpha=np.pi / 2, d=0.3), DHRow(a=0.25), DHRow(a=0.2)], convention="standard", name="j3")


def calibrated(name: str, seed: int, rotation: float = 1e-3, shift: float = 3e-4) -> Arm:
    """A preset with each joint frame turned and moved a little, as a calibration leaves it."""
    rng, model = np.random.default_rng(seed), preset(name)
    joints = []
    for joint in model.joints:
        off, axis, way = np.eye(4), rng.normal(size=3), rng.normal(size=3)
        off[:3, :3] = Rotation.from_rotvec(axis / np.linalg.norm(axis) * rng.uniform(0.1, 1.0) * rotation).as_matrix()
        off[:3, 3] = way / np.linalg.norm(way) * shift
        joints.append(dataclasses.replace(joint, before=constant_transform(np.array(joint.before) @ off)))
    return Arm(dataclasses.replace(model, joints=tuple(joints), bodies=None))
