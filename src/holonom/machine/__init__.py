"""The controller: what turns a program, a path or velocities into commands for drives, real or simulated.

It never sees a plant: measurements come in and commands go out as the arrays of `devices.drive_signals`. Everything
that evolves is explicit state that can be copied.

=====================  =====================================================================================
`ArmMachine`           an arm behind `lang.Machine`: motions, servos (`ArmServos`, `ControlSettings`), hand
`Levels`               periods of supervisor, model and servos; `PointBuffer` between two of them
`BaseController`       a mobile base: keeps a path, follows velocities, holds; settings `BaseSettings`
`plan_path`            a reference for it, along `PATHS` or `waypoints`
`DryMachine`           an arm without dynamics, for off-line checks
`branch_joints`        where a motion to a tool pose ends
`contact_by_currents`  contact force at an arm's tool, by its motors' currents, with its error (`ContactErrors`)
=====================  =====================================================================================
"""

from holonom.control import CONTROLLERS
from holonom.machine.arm.contact import ContactErrors, contact_by_currents
from holonom.machine.arm.dry import DryMachine, Problem
from holonom.machine.arm.machine import ArmMachine
from holonom.machine.arm.motions import LineSettings, branch_joints
from holonom.machine.arm.servos import ArmServos, ControlSettings
from holonom.machine.base.controller import BaseController
from holonom.machine.base.paths import PATHS, PathLimits, ReferencePath, plan_path, waypoints
from holonom.machine.base.settings import BaseSettings, Creep, slip_settings
from holonom.machine.levels import Levels, LevelState, PointBuffer

__all__ = [
    "CONTROLLERS",
    "PATHS",
    "ArmMachine",
    "ArmServos",
    "BaseController",
    "BaseSettings",
    "ContactErrors",
    "ControlSettings",
    "Creep",
    "DryMachine",
    "LevelState",
    "Levels",
    "LineSettings",
    "PathLimits",
    "PointBuffer",
    "Problem",
    "ReferencePath",
    "branch_joints",
    "contact_by_currents",
    "plan_path",
    "slip_settings",
    "waypoints",
]
