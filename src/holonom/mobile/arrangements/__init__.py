"""Bases as they are built: presets, one function each; all lengths in m, angles in rad.

base_link lies where the arrangement is symmetric: at the middle of the driven axle of a differential drive, of the rear
axle of tricycle and car, at the middle of the others.
"""

from holonom.mobile.arrangements.axles import (
    ackermann,
    ackermann_steering,
    bicycle,
    differential,
    dual_ackermann,
    tricycle,
)
from holonom.mobile.arrangements.common import Body
from holonom.mobile.arrangements.holonomic import mecanum, omni, sphere, swerve, synchro
from holonom.mobile.arrangements.others import rocker6, segway, skid_steer

__all__ = [
    "Body", "ackermann", "ackermann_steering", "bicycle", "differential", "dual_ackermann", "mecanum", "omni",
    "rocker6", "segway", "skid_steer", "sphere", "swerve", "synchro", "tricycle",
]  # fmt: skip
