"""The table of what can be simulated, and taken the place of by a real one."""

from __future__ import annotations

from holonom.registry import Method, Table
from holonom.sim.arm.plant import ArmPlant
from holonom.sim.base.plant import BasePlant

__all__ = ["PLANTS"]

PLANTS = Table(
    "plants",
    "plant",
    "its class",
    {
        "arm_with_drives": Method(
            "an arm with motors, gears, encoders and friction, down to the armature current",
            lambda _: ArmPlant,
            "Craig, Introduction to Robotics, ch. 6, 9; Leonhard, Control of Electrical Drives",
        ),
        "base_on_wheels": Method(
            "a mobile base with motors, slip and a rigid body",
            lambda _: BasePlant,
            "Rojas, Foerster, Holonomic Control of a robot with an omnidirectional drive; specification 06.2",
        ),
    },
)
