"""Shapes, distances, ray casts: one set for collisions, ranging sensors, planners and reports.

=================  ==================================================================
`Box`, `Cylinder`  shapes about their own middle, upright; `outline` draws one
`distance`         of points from a shape, negative inside
`ray_cast`         how far rays go until they meet a shape
`hull`, `margin`   of points in the plane; distance of a point within a convex polygon
`gap`              between two convex polygons, negative where they overlap
=================  ==================================================================
"""

from holonom.geometry.distance import distance
from holonom.geometry.polygons import gap, hull, margin, normals_and_offsets
from holonom.geometry.rays import ray_cast
from holonom.geometry.shapes import Box, Cylinder, Shape, outline

__all__ = [
    "Box",
    "Cylinder",
    "Shape",
    "distance",
    "gap",
    "hull",
    "margin",
    "normals_and_offsets",
    "outline",
    "ray_cast",
]
