"""`Arm`: a robot description together with its compiled equations, and how one is loaded."""

from holonom.mechanics.arm.arm import Arm, IkCase, IkNearest, IkResult, IkStatus, Limits
from holonom.mechanics.arm.load import arm_from_dh, load_arm

__all__ = ["Arm", "IkCase", "IkNearest", "IkResult", "IkStatus", "Limits", "arm_from_dh", "load_arm"]
