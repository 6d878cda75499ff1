"""Closed loops: a controller (`holonom.machine`) and a simulated plant (`holonom.sim`), which do not know each other.

=====================  ===========================================================
`BaseLoop`             a base, stepped or in whole buffers: the same bits
`simulate_base`        a base on a path, with its motors, slip and faults: `BaseLog`
`ArmLoop`              an arm with servos and drives, along references
`SimulatedArm`         the same with its hand and work pieces, behind `lang.Machine`
`simulate_axis`        one axis under its drive: `AxisRun`; `AxisFault` breaks it
`tune_axis`            gains of an axis, verified in that simulation
=====================  ===========================================================
"""

from holonom.closed_loop.arm import SimulatedArm
from holonom.closed_loop.arm_loop import ArmLoop
from holonom.closed_loop.axis import AxisRun, simulate_axis
from holonom.closed_loop.axis_faults import AXIS_FAULTS, AxisFault
from holonom.closed_loop.axis_tuning import AxisTuning, WantedAxis, tune_axis
from holonom.closed_loop.base import BaseLoop, simulate_base
from holonom.closed_loop.base_log import BaseLog
from holonom.closed_loop.ideal_arm import IdealArm

__all__ = [
    "AXIS_FAULTS",
    "ArmLoop",
    "AxisFault",
    "AxisRun",
    "AxisTuning",
    "BaseLog",
    "BaseLoop",
    "IdealArm",
    "SimulatedArm",
    "WantedAxis",
    "simulate_axis",
    "simulate_base",
    "tune_axis",
]
