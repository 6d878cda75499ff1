"""Pictures of arms and mobile bases: figures for papers (Matplotlib), a page to look around in (Plotly).

=======================  ======================================================================
`draw_arm`               an arm at one or several configurations, as sticks with frames
`draw_workspace`         what the tool point reaches in a slice of the room
`draw_manipulability`    a map of manipulability over two joints
`draw_ellipsoids`        velocity and force ellipsoid at a configuration
`draw_profiles`          positions, speeds and accelerations of a motion beside their limits
`draw_base`              a base from above: wheels, axles, twist, centre of rotation
`draw_effective_motors`  effective number of motors by direction, with and without dead ones
`draw_envelopes`         force, acceleration or speed by direction; dashed where the floor binds
`draw_slip`              what no twist explains over time, and the wheel that is named
`draw_odometry`          paths of runs: truth, nominal and calibrated odometry
`arm_page`               an arm, or its motion, to turn and play in a browser
=======================  ======================================================================

Extra "plots". Every function returns the figure and, with `save=`, writes it too; pyplot's state is not touched.
"""

from holonom.plots.arm import draw_arm
from holonom.plots.base import draw_base
from holonom.plots.drive import draw_effective_motors, draw_envelopes, draw_slip
from holonom.plots.ellipsoids import draw_ellipsoids
from holonom.plots.maps import draw_manipulability, draw_workspace
from holonom.plots.odometry import draw_odometry
from holonom.plots.page import arm_page
from holonom.plots.profiles import draw_profiles

__all__ = [
    "arm_page",
    "draw_arm",
    "draw_base",
    "draw_effective_motors",
    "draw_ellipsoids",
    "draw_envelopes",
    "draw_manipulability",
    "draw_odometry",
    "draw_profiles",
    "draw_slip",
    "draw_workspace",
]
