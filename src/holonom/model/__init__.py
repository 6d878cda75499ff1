"""What a robot is: data only.

=====================  ==========================================================
`ArmModel`             joints, bodies, base, tool, gravity
`DHRow`                one row of a Denavit-Hartenberg table
`preset`               the arms that come with Holonom
=====================  ==========================================================
"""

from holonom.model.arm import (
    ArmModel,
    Body,
    Frame,
    Friction,
    Joint,
    JointLimits,
    Mimic,
    Motor,
    Transform,
    constant_transform,
)
from holonom.model.dh import DHRow, arm_model_from_dh, joint_from_dh
from holonom.model.presets import preset, preset_names

__all__ = [
    "ArmModel",
    "Body",
    "DHRow",
    "Frame",
    "Friction",
    "Joint",
    "JointLimits",
    "Mimic",
    "Motor",
    "Transform",
    "arm_model_from_dh",
    "constant_transform",
    "joint_from_dh",
    "preset",
    "preset_names",
]
