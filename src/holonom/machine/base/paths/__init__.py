"""Reference paths of a base: shapes, from pose to pose, in time."""

from holonom.machine.base.paths.shapes import (
    HEADINGS,
    PATHS,
    ClosedCurve,
    Heading,
    PathLimits,
    ReferencePath,
    Waypoints,
    circle,
    figure_of_eight,
    plan_path,
    sampled,
    waypoints,
)

__all__ = [
    "HEADINGS",
    "PATHS",
    "ClosedCurve",
    "Heading",
    "PathLimits",
    "ReferencePath",
    "Waypoints",
    "circle",
    "figure_of_eight",
    "plan_path",
    "sampled",
    "waypoints",
]
