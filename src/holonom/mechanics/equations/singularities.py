"""How far an arm is from its singularities: the volume of a Jacobian, and measures of named ones."""

from __future__ import annotations

from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.inverse.puma_geometry import PumaGeometry
from holonom.mechanics.equations.vectors import Matrix, Vector, add, compose, cross, dot, scale, sub
from holonom.model import ArmModel
from holonom.trace import Number, cos, less, select, sin, sqrt

__all__ = ["parallel_measures", "puma_measures", "volume"]


def volume(rows: Matrix) -> Number:
    """Volume that the rows of A span, sqrt(det(A A^T)): the product of what each adds at right angles to those before.

    By modified Gram-Schmidt, whose lengths are as accurate as those of a QR factorisation; det(A A^T) itself loses
    half of the digits near 0.
    """
    result: Number = 1.0
    rest = [list(row) for row in rows]
    while rest:
        first, *rest = rest
        square = dot(first, first)
        result = result * sqrt(square)
        inverse = select(less(0.0, square), 1.0 / select(less(0.0, square), square, 1.0), 0.0)
        rest = [sub(row, scale(dot(row, first) * inverse, first)) for row in rest]
    return result


def puma_measures(k: PumaGeometry, q: Vector) -> list[Number]:
    """Shoulder, elbow (m) and wrist of an arm like the Puma 560 (specification 1.4), each 0 at its singularity."""
    q23 = q[1] + q[2]
    return [
        k.a2 * cos(q[1]) + k.a3 * cos(q23) - k.d4 * sin(q23),
        k.a3 * sin(q[2]) + k.d4 * cos(q[2]),
        sin(q[4]),
    ]


def parallel_measures(model: ArmModel, q: Vector) -> list[Number]:
    """Shoulder (m), elbow and wrist of an arm whose axes 2, 3 and 4 are parallel and whose axes 5 and 6 meet (UR)."""
    frames = kinematics.frames(model, q)
    at = [compose(frames[model.parent(i) + 1], kinematics.split(j.before)) for i, j in enumerate(model.joints)]
    z, p = [[row[2] for row in R] for R, _ in at], [origin for _, origin in at]
    side, across = cross(z[0], z[1]), cross(z[5], z[4])
    upper, fore = cross(z[1], sub(p[2], p[1])), cross(z[1], sub(p[3], p[2]))  # across the axes, turned by 90 deg
    along = dot(cross(sub(p[4], p[5]), z[4]), across) / dot(across, across)
    meeting = add(p[5], scale(along, z[5]))
    return [
        dot(sub(meeting, p[1]), side) / _length(side),
        dot(cross(upper, fore), z[1]) / (_length(upper) * _length(fore)),
        _length(cross(z[3], z[5])),
    ]


def _length(a: Vector) -> Number:
    return sqrt(dot(a, a))
