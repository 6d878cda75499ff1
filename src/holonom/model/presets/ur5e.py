"""Universal Robots UR5e.

Model card
----------
::

      z_0 up      2---- 0.425 ----3---- 0.3922 ----4      joints 2, 3, 4 are parallel; offsets d4 = 0.1333,
           0.1625 |                                |      d5 = 0.0997, d6 = 0.0996 (flange) follow one another
                  1 (base)                         5-6    at right angles. q = 0: stretched along -x_0.

Kinematics, masses and centres of mass: Universal Robots, "DH parameters for calculations of kinematics and dynamics"
(support article; standard DH, nominal values: a real arm carries its own calibration). Inertias about the centres of
mass, axes of the DH frames: `physical_parameters.yaml` of the maker's ROS description (numbers only). Position limits
+-360 degrees (elbow +-180), speed 180 degrees/s, torque 150 and 28 N m: data sheet and the same description.

APPROXIMATE: rotor inertias and friction are not published and are left out, which makes the arm lighter to accelerate
than the machine; the acceleration limits (the controller's usual 800 degrees/s2 at most) are a setting.
"""

from __future__ import annotations

import dataclasses
import math

from holonom.model.arm import ArmModel, Body
from holonom.model.dh import DHRow, arm_model_from_dh
from holonom.model.limits import JointLimits

__all__ = ["model"]

NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
HALF = math.pi / 2
ROWS = (
    DHRow(d=0.1625, alpha=HALF),
    DHRow(a=-0.425),
    DHRow(a=-0.3922),
    DHRow(d=0.1333, alpha=HALF),
    DHRow(d=0.0997, alpha=-HALF),
    DHRow(d=0.0996),
)
BODIES = (
    Body(
        3.761,
        (0.0, -0.02561, 0.00193),
        (0.00700210, 0.00648091, 0.00657286, 0.00000073, 0.00049994, -0.00001053),
    ),
    Body(8.058, (0.2125, 0.0, 0.11336), (0.01505885, 0.33388086, 0.33247207, -0.000054, -0.00000181, 0.00000563)),
    Body(2.846, (0.15, 0.0, 0.0265), (0.00399632, 0.07879254, 0.07848510, -0.00001365, -0.0000066, 0.00137272)),
    Body(1.37, (0.0, -0.0018, 0.01634), (0.00165491, 0.00135962, 0.00126279, -0.00000282, 0.00010157, -0.00000438)),
    Body(1.3, (0.0, 0.0018, 0.01634), (0.00135617, 0.00127827, 0.00096614, -0.00000274, -0.00005048, 0.00000444)),
    Body(0.365, (0.0, 0.0, -0.001159), (0.00018694, 0.00018908, 0.00025756, 0.00000006, -0.00000092, -0.00000017)),
)
TURNS = (2.0, 2.0, 1.0, 2.0, 2.0, 2.0)  # position limits, times pi
TORQUE = (150.0, 150.0, 150.0, 28.0, 28.0, 28.0)
POSES = {"zero": (0.0,) * 6, "ready": (0.0, -HALF, HALF, -HALF, -HALF, 0.0)}


def model() -> ArmModel:
    """Return the UR5e (see the module's model card)."""
    limits = [
        JointLimits(-k * math.pi, k * math.pi, math.pi, math.radians(800), tau)
        for k, tau in zip(TURNS, TORQUE, strict=True)
    ]
    arm = arm_model_from_dh(ROWS, convention="standard", name="ur5e", limits=limits, bodies=BODIES)
    joints = tuple(dataclasses.replace(joint, name=name) for joint, name in zip(arm.joints, NAMES, strict=True))
    return dataclasses.replace(arm, joints=joints, poses=POSES, card=__doc__ or "")
