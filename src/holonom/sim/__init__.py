"""Simulated plants: an arm and a mobile base with drives and sensors, work pieces, floors. No controller is here.

=====================  ===========================================================
`ArmPlant`             an arm with drives and encoders
`World`                surfaces and parts; `Fingers` of a gripper move them
`BasePlant`            a mobile base on a `Floor` of `Material` with patches; `BaseFault` breaks its motors
`BaseTruth`            what was true of it
`Axis`, `Load`         one axis; `simulate_axis` runs it under its servo (of `holonom.closed_loop`)
`PLANTS`, `SENSORS`    tables of what there is to simulate
=====================  ===========================================================
"""

from importlib import import_module
from typing import Any

from holonom.sim.arm.plant import ArmPlant, AxisDrive, Ground
from holonom.sim.arm.world import Disc, Fingers, Gripper, Surface, World
from holonom.sim.axis.axis import Axis, Load
from holonom.sim.base.floor import CARPET, ICE, Floor, Material, RectangularPatch, RoundPatch, Step
from holonom.sim.base.log import BaseTruth
from holonom.sim.base.plant import BaseFault, BasePlant
from holonom.sim.plants import PLANTS
from holonom.sim.sensors import SENSORS

__all__ = [
    "CARPET",
    "ICE",
    "PLANTS",
    "SENSORS",
    "ArmPlant",
    "Axis",
    "AxisDrive",
    "BaseFault",
    "BasePlant",
    "BaseTruth",
    "Disc",
    "Fingers",
    "Floor",
    "Gripper",
    "Ground",
    "Load",
    "Material",
    "RectangularPatch",
    "RoundPatch",
    "Step",
    "Surface",
    "World",
]


def __getattr__(name: str) -> Any:
    """`simulate_axis` closes a loop, which nothing here may; this is where one looks for it, and for its faults."""
    if name in ("AxisFault", "simulate_axis"):
        return getattr(import_module("holonom.closed_loop"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
