"""Motion: time laws, joint and tool trajectories, retiming, fly-by and stops.

================  =====================================================================
``profile``       `time_law`, `sample`, `on_grid`: s(t) from 0 to 1; families in `PROFILES`
``trajectory``    `Trajectory`: the sampled joint path; `JointLimits`: what it keeps
``joint``         `plan_joint`: point to point, all joints arrive together
``line``          `plan_line`: straight line of the tool, orientation by slerp
``path``          `plan_path`: lines, arcs and splines of the tool, fly-by between them
``joint_path``    `joint_spline`: where the joints go, without a time
``retime``        `retime`: least time along a joint path; speed, acceleration and torque limits
``transfer``      `plan_transfer`: least time between moving states, jerk limited too
``blend``         `blend`, `splice`: the next segment starts while the last one brakes
``stop``          `stop`: a controlled stop on the path
``methods``       `PLANNERS`, the table of the planners
================  =====================================================================
"""

from holonom.mechanics.motion.blend import blend, splice
from holonom.mechanics.motion.joint import plan_joint
from holonom.mechanics.motion.joint_path import JointPath, joint_spline
from holonom.mechanics.motion.line import plan_line
from holonom.mechanics.motion.methods import PLANNERS
from holonom.mechanics.motion.path import ArcAbout, ArcTo, LineTo, Segment, SplineTo, plan_path
from holonom.mechanics.motion.profile import (
    PROFILES,
    GridSamples,
    Law,
    LawSamples,
    Rise,
    on_grid,
    sample,
    time_law,
)
from holonom.mechanics.motion.retime import DynamicArm, retime
from holonom.mechanics.motion.stop import stop
from holonom.mechanics.motion.tool import InverseSolutions, LineArm
from holonom.mechanics.motion.trajectory import JointLimits, Trajectory
from holonom.mechanics.motion.transfer import plan_transfer

__all__ = [
    "PLANNERS",
    "PROFILES",
    "ArcAbout",
    "ArcTo",
    "DynamicArm",
    "GridSamples",
    "InverseSolutions",
    "JointLimits",
    "JointPath",
    "Law",
    "LawSamples",
    "LineArm",
    "LineTo",
    "Rise",
    "Segment",
    "SplineTo",
    "Trajectory",
    "blend",
    "joint_spline",
    "on_grid",
    "plan_joint",
    "plan_line",
    "plan_path",
    "plan_transfer",
    "retime",
    "sample",
    "splice",
    "stop",
    "time_law",
]
