"""Stanford arm (V. Scheinman 1969): two revolute joints, one prismatic, a spherical wrist.

Model card
----------
::

            ___2___ d2                  z_0 up along the post; joint 2 across it; the boom slides along z_2.
           |       \\ q3 (boom)          All angles zero: the boom points up, the wrist is straight.
      0.412|        \\
           1         4-5-6 tool         The wrist's three axes meet at the end of the boom.

Kinematics: standard DH as in R. P. Paul, Robot Manipulators (1981) and the Robotics Toolbox's Stanford model (numbers
only): d1 = 0.412 m, d2 = 0.154 m, boom 0.3048 ... 1.27 m, a3 = 0.0203 m, limits as there. The tool point is the wrist's
centre, as in that table.

Dynamics: masses and actuator inertias (at the joint: gear ratio 1) after A. K. Bejczy, JPL TM 33-669 (1974), as Paul
prints them. APPROXIMATE: the centres of mass and the inertias. The tables in circulation mix metres, decimetres and
reference points; here the centres are Bejczy's centimetres as far as they can be told apart, and each inertia that of
a body of that mass and about that size: use them to exercise code, not to model the machine. Speed, acceleration and
torque limits and friction are not stated.
"""

from __future__ import annotations

import dataclasses
import math

from holonom.model.arm import ArmModel, Body, Motor
from holonom.model.dh import DHRow, arm_model_from_dh
from holonom.model.joint_kinds import kind_of
from holonom.model.limits import JointLimits

__all__ = ["model"]

HALF = math.pi / 2
ROWS = (
    DHRow(d=0.412, alpha=-HALF),
    DHRow(d=0.154, alpha=HALF),
    DHRow(a=0.0203, theta=-HALF, kind="prismatic"),
    DHRow(alpha=-HALF),
    DHRow(alpha=HALF),
    DHRow(),
)
LIMITS_DEG = (170.0, 170.0, 0.0, 170.0, 90.0, 170.0)
BOOM = (0.3048, 1.27)
MASS = (9.29, 5.01, 4.25, 1.08, 0.63, 0.51)
COM = (
    (0.0, 0.0175, -0.1105),
    (0.0, -0.1054, 0.0),
    (0.0, 0.0, -0.6447),
    (0.0, 0.0092, -0.0054),
    (0.0, 0.0566, 0.0003),
    (0.0, 0.0, 0.1554),
)
INERTIA = (
    (0.160, 0.142, 0.068),
    (0.052, 0.018, 0.044),
    (0.744, 0.744, 0.006),
    (0.002, 0.001, 0.001),
    (0.001, 0.0004, 0.001),
    (0.0007, 0.0007, 0.0003),
)
ACTUATOR_INERTIA = (0.953, 2.193, 0.782, 0.106, 0.097, 0.020)
POSES = {"zero": (0.0, 0.0, 0.5, 0.0, 0.0, 0.0), "ready": (0.0, HALF, 0.6, 0.0, HALF / 2, 0.0)}


def model() -> ArmModel:
    """Return the Stanford arm (see the module's model card)."""
    turning = [JointLimits(-math.radians(a), math.radians(a)) for a in LIMITS_DEG]
    arm = arm_model_from_dh(
        ROWS,
        convention="standard",
        name="stanford",
        limits=[JointLimits(*BOOM) if not kind_of(row.kind).turns else a for row, a in zip(ROWS, turning, strict=True)],
        bodies=[Body(m, c, (*i, 0.0, 0.0, 0.0)) for m, c, i in zip(MASS, COM, INERTIA, strict=True)],
    )
    joints = tuple(
        dataclasses.replace(joint, motor=Motor(gear_ratio=1.0, rotor_inertia=inertia))
        for joint, inertia in zip(arm.joints, ACTUATOR_INERTIA, strict=True)
    )
    return dataclasses.replace(arm, joints=joints, poses=POSES, card=__doc__ or "")
