"""The simulated cell and the simulated base: plant, clock, work pieces, and the machines a program can drive.

=====================  ===========================================================
`Plant`                an arm with drives, encoders and servo loops
`World`                table, tray, parts and the gripper
`SimulatedMachine`     all of it behind `lang.Machine`
`DryMachine`           the same without dynamics, for off-line checks
`branch_joints`        where a motion to a tool pose ends
`simulate_base`        a mobile base on a path, with its motors, slip and faults: `BaseLog`
`BasePlant`            its plant: `BaseDrive`, on a `Floor` of `Material` with patches
`plan_path`            a reference for it, along `PATHS` or `waypoints`
`PLANTS`, `SENSORS`    tables of what there is to simulate
=====================  ===========================================================
"""

from holonom.control import CONTROLLERS
from holonom.sim.arm.dry import DryMachine, Problem
from holonom.sim.arm.machine import PROGRAM_TICK, SimulatedMachine
from holonom.sim.arm.motions import LineSettings, branch_joints
from holonom.sim.arm.plant import ControlSettings, Ground, Plant
from holonom.sim.arm.world import Disc, Gripper, Surface, World
from holonom.sim.base.floor import CARPET, ICE, Floor, Material, RectangularPatch, RoundPatch
from holonom.sim.base.log import BaseLog
from holonom.sim.base.paths import PATHS, PathLimits, ReferencePath, plan_path, waypoints
from holonom.sim.base.plant import BaseDrive, BasePlant
from holonom.sim.base.simulation import BaseFault, BaseSensors, BaseSettings, Creep, simulate_base, slip_settings
from holonom.sim.methods import PLANTS, SENSORS

__all__ = [
    "CARPET",
    "CONTROLLERS",
    "ICE",
    "PATHS",
    "PLANTS",
    "PROGRAM_TICK",
    "SENSORS",
    "BaseDrive",
    "BaseFault",
    "BaseLog",
    "BasePlant",
    "BaseSensors",
    "BaseSettings",
    "ControlSettings",
    "Creep",
    "Disc",
    "DryMachine",
    "Floor",
    "Gripper",
    "Ground",
    "LineSettings",
    "Material",
    "PathLimits",
    "Plant",
    "Problem",
    "RectangularPatch",
    "ReferencePath",
    "RoundPatch",
    "SimulatedMachine",
    "Surface",
    "World",
    "branch_joints",
    "plan_path",
    "simulate_base",
    "slip_settings",
    "waypoints",
]
