"""Kinematics, dynamics and motion of arms.

=====================  ================================================================
`Arm`, `load_arm`      the verbs: fk, jacobian, ik, inverse_dynamics, ...
`mechanics.motion`     joint and tool trajectories, blending, retiming
`mechanics.simulate`   an arm alone: free, under a law, many variations at once
`mechanics.equations`  the textbook's equations, over floats or traced scalars
=====================  ================================================================
"""

from holonom.mechanics import motion, simulate
from holonom.mechanics.arm import Arm, IkCase, IkNearest, IkResult, IkStatus, Limits, arm_from_dh, load_arm

__all__ = [
    "Arm",
    "IkCase",
    "IkNearest",
    "IkResult",
    "IkStatus",
    "Limits",
    "arm_from_dh",
    "load_arm",
    "motion",
    "simulate",
]
