"""Kinematics, dynamics and motion of arms.

=======================  =====================================================================
`Arm`, `load_arm`        the everyday verbs: fk, jacobian, ik, inverse_dynamics, ...
`all_solutions`          of an offset wrist; `swivel_solutions` of seven joints
`analysis`               manipulability, ellipsoids, named singularities, statics
`jacobians`              analytic Jacobians, Jacobian rates, Hessian
`paths`                  closed-form branches along a path
`numerical_inverse`      inverse of any chain: limits, restarts, nullspace criteria
`velocity`               joint rates near singularities, following a path without drift
`dynamics`               derivatives, Coriolis table, energies, momenta, payload
`identification`         regressor, base parameters, excitation, estimates
`symbolic`               any of the equations as readable formulas
`motion`                 joint and tool trajectories, blending, retiming
`simulate`               an arm alone: free, under a law, many variations at once
`equations`              the textbook's equations, over floats or traced scalars
=======================  =====================================================================
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from holonom.mechanics.arm.arm import Arm, IkCase, IkNearest, IkResult, IkStatus, Limits
from holonom.mechanics.arm.load import arm_from_dh, load_arm

if TYPE_CHECKING:
    from holonom.mechanics import (
        analysis,
        dynamics,
        identification,
        jacobians,
        motion,
        numerical_inverse,
        paths,
        velocity,
    )
    from holonom.mechanics.arm.locked import all_solutions, swivel_solutions
    from holonom.mechanics.simulate import simulate
    from holonom.mechanics.symbolic import formulas as symbolic

_MODULES = (
    "analysis",
    "dynamics",
    "identification",
    "jacobians",
    "motion",
    "numerical_inverse",
    "paths",
    "simulate",
    "symbolic",
    "velocity",
)
_LATE = dict.fromkeys(("all_solutions", "swivel_solutions"), "holonom.mechanics.arm.locked")
"""Functions whose module is loaded when they are first asked for."""
__all__ = [
    "Arm",
    "IkCase",
    "IkNearest",
    "IkResult",
    "IkStatus",
    "Limits",
    "all_solutions",
    "analysis",
    "arm_from_dh",
    "dynamics",
    "identification",
    "jacobians",
    "load_arm",
    "motion",
    "numerical_inverse",
    "paths",
    "simulate",
    "swivel_solutions",
    "symbolic",
    "velocity",
]


def __getattr__(name: str) -> Any:
    """Load a subject's module on first use."""
    if name in _MODULES:
        return importlib.import_module(f"holonom.mechanics.{name}")
    if name in _LATE:
        return getattr(importlib.import_module(_LATE[name]), name)
    raise AttributeError(f"module 'holonom.mechanics' has no attribute {name!r}; it has {', '.join(__all__)}")
