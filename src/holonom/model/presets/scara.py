"""SCARA arm of the Cobra 600 class: two links in a horizontal plane, a quill that slides down and turns.

Model card
----------
::

      z up   1--- 0.325 ---2--- 0.275 ---.       joints 1, 2: about z
             |                          3|       joint 3: q3 > 0 slides down, 0 ... 0.21 m
           0.387                         v       joint 4: turns about the quill (z down)
           (base)                       tool     q = 0: both links along x

Kinematics: standard DH as in the Robotics Toolbox's Cobra600 model (numbers only): d1 = 0.387 m, a1 = 0.325 m,
a2 = 0.275 m, quill 0.21 m. Limits: joints 1, 2, 4 +-105, +-150, +-360 degrees; speeds 386, 720, 1200 degrees/s and
1.1 m/s, which is about what makers state for this class.

APPROXIMATE, made up: masses, centres of mass, inertias (solid cylinders), accelerations, torques.
"""

from __future__ import annotations

import dataclasses
import math

from holonom.model.arm import ArmModel
from holonom.model.dh import DHRow, arm_model_from_dh
from holonom.model.limits import JointLimits
from holonom.model.presets.shapes import cylinder

__all__ = ["model"]

NAMES = ("shoulder", "elbow", "quill", "spin")
ROWS = (
    DHRow(d=0.387, a=0.325),
    DHRow(a=0.275, alpha=math.pi),
    DHRow(kind="prismatic"),
    DHRow(),
)
LIMITS = (
    JointLimits(-math.radians(105), math.radians(105), math.radians(386), 30.0, 200.0),
    JointLimits(-math.radians(150), math.radians(150), math.radians(720), 60.0, 80.0),
    JointLimits(0.0, 0.21, 1.1, 20.0, 150.0),
    JointLimits(-math.radians(360), math.radians(360), math.radians(1200), 150.0, 5.0),
)
BODIES = (
    cylinder(12.0, 0.325, 0.06, "x", -0.325),
    cylinder(8.0, 0.275, 0.06, "x", -0.275),
    cylinder(1.5, 0.30, 0.01, "z", -0.30),
    cylinder(0.5, 0.03, 0.03, "z"),
)
POSES = {"zero": (0.0, 0.0, 0.0, 0.0), "ready": (-math.pi / 4, math.pi / 2, 0.1, 0.0)}


def model() -> ArmModel:
    """Return the SCARA arm (see the module's model card)."""
    arm = arm_model_from_dh(ROWS, convention="standard", name="scara", limits=LIMITS, bodies=BODIES)
    joints = tuple(dataclasses.replace(joint, name=name) for joint, name in zip(arm.joints, NAMES, strict=True))
    return dataclasses.replace(arm, joints=joints, poses=POSES, card=__doc__ or "")
