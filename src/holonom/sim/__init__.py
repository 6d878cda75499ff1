"""The simulated cell: plant, clock, work pieces, and the machines a program can drive.

=====================  ===========================================================
`Plant`                an arm with drives, encoders and servo loops
`World`                table, tray, parts and the gripper
`SimulatedMachine`     all of it behind `lang.Machine`
`DryMachine`           the same without dynamics, for off-line checks
`branch_joints`        where a motion to a tool pose ends
=====================  ===========================================================
"""

from holonom.sim.dry import DryMachine, Problem
from holonom.sim.machine import PROGRAM_TICK, SimulatedMachine
from holonom.sim.motions import LineSettings, branch_joints
from holonom.sim.plant import CONTROLLERS, ControlSettings, Ground, Plant
from holonom.sim.world import Disc, Gripper, Surface, World

__all__ = [
    "CONTROLLERS",
    "PROGRAM_TICK",
    "ControlSettings",
    "Disc",
    "DryMachine",
    "Gripper",
    "Ground",
    "LineSettings",
    "Plant",
    "Problem",
    "SimulatedMachine",
    "Surface",
    "World",
    "branch_joints",
]
