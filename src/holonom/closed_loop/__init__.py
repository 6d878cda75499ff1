"""Closed loops: a controller (`holonom.machine`) and a simulated plant (`holonom.sim`), which do not know each other.

=====================  ===========================================================
`BaseLoop`             a base, stepped or in whole buffers: the same bits
`simulate_base`        a base on a path, with its motors, slip and faults: `BaseLog`
`ArmLoop`              an arm with servos and drives, along references
`SimulatedArm`         the same with its hand and work pieces, behind `lang.Machine`
`simulate_axis`        one axis under the loops of its servo: `AxisRun`
=====================  ===========================================================
"""

from holonom.closed_loop.arm import SimulatedArm
from holonom.closed_loop.arm_loop import ArmLoop
from holonom.closed_loop.axis import AxisRun, simulate_axis
from holonom.closed_loop.base import BaseLoop, simulate_base
from holonom.closed_loop.base_log import BaseLog
from holonom.closed_loop.ideal_arm import IdealArm

__all__ = [
    "ArmLoop",
    "AxisRun",
    "BaseLog",
    "BaseLoop",
    "IdealArm",
    "SimulatedArm",
    "simulate_axis",
    "simulate_base",
]
