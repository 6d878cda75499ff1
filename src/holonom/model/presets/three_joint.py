"""The 3-joint arm of specification 08: a turning column and two links in a vertical plane.

Model card
----------
::

          2--- l1 ---3--- l2 ---tool        x = (l1 cos b + l2 cos(b + g)) cos a
          |                                 y = (l1 cos b + l2 cos(b + g)) sin a
         z0   z up, x away from the column  z = z0 + l1 sin b + l2 sin(b + g)
          |
          1 (base)                          q = (a, b, g), all zero: both links level along x

Standard DH, tool at the end of the second link. Link lengths, limits and masses are made up for a table-top teaching
arm (aluminium tubes taken as solid cylinders of the stated masses): no machine has them. The geometry is the
specification's, with x0 = y0 = 0; move it with the base transform.
"""

from __future__ import annotations

import dataclasses
import math

from holonom.model.arm import ArmModel, Friction, Motor
from holonom.model.dh import DHRow, arm_model_from_dh
from holonom.model.limits import JointLimits
from holonom.model.presets.shapes import cylinder

__all__ = ["model"]

HEIGHT, UPPER, FORE = 0.30, 0.30, 0.25  # z0, l1, l2
NAMES = ("column", "shoulder", "elbow")
ROWS = (DHRow(d=HEIGHT, alpha=math.pi / 2), DHRow(a=UPPER), DHRow(a=FORE))
LIMITS_DEG = ((-170, 170), (-30, 150), (-150, 150))
BODIES = (
    cylinder(3.0, HEIGHT, 0.05, "y", -HEIGHT),
    cylinder(1.5, UPPER, 0.025, "x", -UPPER),
    cylinder(0.8, FORE, 0.02, "x", -FORE),
)
MOTOR = Motor(gear_ratio=100.0, rotor_inertia=5e-6, axis=(0.0, 0.0, 1.0))
FRICTION = Friction(0.1, 0.2, 0.2)
POSES = {"zero": (0.0, 0.0, 0.0), "ready": (0.0, math.pi / 3, -math.pi / 2)}


def model() -> ArmModel:
    """Return the 3-joint arm (see the module's model card)."""
    limits = [JointLimits(math.radians(a), math.radians(b), 3.0, 15.0, 20.0) for a, b in LIMITS_DEG]
    arm = arm_model_from_dh(ROWS, convention="standard", name="three_joint", limits=limits, bodies=BODIES)
    joints = tuple(
        dataclasses.replace(joint, name=name, motor=MOTOR, friction=FRICTION)
        for joint, name in zip(arm.joints, NAMES, strict=True)
    )
    return dataclasses.replace(arm, joints=joints, poses=POSES, card=__doc__ or "")
