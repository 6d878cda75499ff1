"""A job in motion: its robots, what they touch, and what all of them record, tick by tick.

=====================  ===========================================================
`Rig`                  all of it: `run` to the end, or until somebody says stop
`ArmRig`, `BaseRig`    one robot with its program or task; both are `RobotRig`
`Ended`                how a run ended
=====================  ===========================================================
"""

from holonom.app.rig.arm import ArmRig
from holonom.app.rig.base import BaseRig
from holonom.app.rig.ending import Ended, Ending
from holonom.app.rig.rig import Rig, Simulated, simulated
from holonom.app.rig.robot import RobotRig

__all__ = ["ArmRig", "BaseRig", "Ended", "Ending", "Rig", "RobotRig", "Simulated", "simulated"]
