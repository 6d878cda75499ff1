"""What a robot is: data only.

=====================  ==========================================================
`ArmModel`             joints, bodies, base, tool, gravity
`DHRow`                one row of a Denavit-Hartenberg table
`preset`               the arms that come with Holonom, listed in `PRESETS`
`JOINT_KINDS`          revolute and prismatic
`read_urdf`            a URDF file or text; `load_model` any of these by name or file
=====================  ==========================================================
"""

from holonom.model.arm import (
    ArmModel,
    Body,
    Frame,
    Friction,
    Joint,
    Mimic,
    Motor,
    Transform,
    constant_transform,
)
from holonom.model.chain import ToolChain, tool_chain
from holonom.model.dh import DHRow, arm_model_from_dh, joint_from_dh
from holonom.model.joint_kinds import JOINT_KINDS
from holonom.model.limits import LIMIT_TOLERANCE, JointLimits, outside
from holonom.model.load import load_model
from holonom.model.presets import PRESETS, preset, preset_names
from holonom.model.reach import STROKE, reach
from holonom.model.urdf.reader import read_urdf

__all__ = [
    "JOINT_KINDS",
    "LIMIT_TOLERANCE",
    "PRESETS",
    "STROKE",
    "ArmModel",
    "Body",
    "DHRow",
    "Frame",
    "Friction",
    "Joint",
    "JointLimits",
    "Mimic",
    "Motor",
    "ToolChain",
    "Transform",
    "arm_model_from_dh",
    "constant_transform",
    "joint_from_dh",
    "load_model",
    "outside",
    "preset",
    "preset_names",
    "reach",
    "read_urdf",
    "tool_chain",
]
