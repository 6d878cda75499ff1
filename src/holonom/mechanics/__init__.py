"""Kinematics, dynamics and motion of arms.

=====================  ================================================================
`Arm`, `load_arm`      the verbs: fk, jacobian, ik, inverse_dynamics, ...
`mechanics.motion`     joint and straight-line trajectories, blending
`mechanics.equations`  the textbook's equations, over floats or traced scalars
=====================  ================================================================
"""

from holonom.mechanics import motion
from holonom.mechanics.arm import Arm, IkNearest, IkResult, IkStatus, Limits, arm_from_dh, load_arm

__all__ = ["Arm", "IkNearest", "IkResult", "IkStatus", "Limits", "arm_from_dh", "load_arm", "motion"]
