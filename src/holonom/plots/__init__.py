"""Pictures of arms: figures for papers (Matplotlib) and a page to look around in (Plotly); extra "plots".

======================  ====================================================================
`draw_arm`              an arm at one or several configurations, as sticks with frames
`draw_workspace`        what the tool point reaches in a slice of the room
`draw_manipulability`   a map of manipulability over two joints
`draw_ellipsoids`       velocity and force ellipsoid at a configuration
`draw_profiles`         positions, speeds and accelerations of a motion beside their limits
`arm_page`              an arm, or its motion, to turn and play in a browser
======================  ====================================================================

Every function returns the figure and, with `save=`, writes it too; nothing touches pyplot's global state.
"""

from holonom.plots.arm import draw_arm
from holonom.plots.ellipsoids import draw_ellipsoids
from holonom.plots.maps import draw_manipulability, draw_workspace
from holonom.plots.page import arm_page
from holonom.plots.profiles import draw_profiles

__all__ = ["arm_page", "draw_arm", "draw_ellipsoids", "draw_manipulability", "draw_profiles", "draw_workspace"]
