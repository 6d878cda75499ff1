"""Rigid transforms as the language writes them: x, y, z in mm and o, a, t in degrees.

The three angles are Z-Y-Z Euler angles about the moved axes (Craig 2005, eq. 2.72):
`R = Rz(o) Ry(a) Rz(t)`. A tool that points straight down has a = 180.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from holonom.errors import ProgramFault
from holonom.lang.machine import Array
from holonom.lang.vm.formats import shown

__all__ = ["angles", "compound", "frame", "joint_unit", "precision_point", "shift", "transformation"]

_MM = 1e-3
_FARTHEST = 1e6


def transformation(values: Sequence[float]) -> Array:
    """Return the pose (4, 4) in m of `x, y, z` in mm and Z-Y-Z angles `o, a, t` in degrees."""
    x, y, z, *turns = _checked(values)
    (co, ca, ct), (so, sa, st) = zip(*map(_cos_sin, turns), strict=True)
    return np.array(
        [
            [co * ca * ct - so * st, -co * ca * st - so * ct, co * sa, x * _MM],
            [so * ca * ct + co * st, -so * ca * st + co * ct, so * sa, y * _MM],
            [-sa * ct, sa * st, ca, z * _MM],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def angles(pose: Array) -> tuple[float, ...]:
    """Return `x, y, z` in mm and `o, a, t` in degrees of a pose (4, 4) in m; t = 0 where a is 0 or 180."""
    R = pose[:3, :3]
    sa = math.hypot(R[0, 2], R[1, 2])
    a = math.atan2(sa, R[2, 2])
    if sa > 1e-9:
        o, t = math.atan2(R[1, 2], R[0, 2]), math.atan2(R[2, 1], -R[2, 0])
    else:
        o, t = math.atan2(-R[0, 1], R[1, 1]), 0.0
    return (*(float(v) / _MM for v in pose[:3, 3]), *map(math.degrees, (o, a, t)))


def shift(pose: Array, dx: float, dy: float, dz: float) -> Array:
    """Return the pose displaced by mm along the axes it is given in; its orientation stays."""
    result = pose.copy()
    result[:3, 3] += np.array(_checked((dx, dy, dz))) * _MM
    return result


def compound(first: Array, second: Array) -> Array:
    """Return `first : second`, the second pose given in the frame of the first."""
    result = first @ second
    _checked(result[:3, 3] / _MM)
    return result


def frame(origin: Array, on_x: Array, near_y: Array, placed: Array) -> Array:
    """Return the frame with its x axis from `origin` to `on_x` and `near_y` on the positive y side.

    Only the positions of the four poses (4, 4) count; the origin of the result is that of `placed`.

    Raises
    ------
    ProgramFault
        When the first three points lie on one line (within 1e-6 of their distance).
    """
    x, y = (on_x - origin)[:3, 3], (near_y - origin)[:3, 3]
    z = np.cross(x, y)
    size = float(np.linalg.norm(z))
    if size <= 1e-6 * max(float(np.dot(x, x)), float(np.dot(y, y))):
        raise ProgramFault("FRAME: the first three points lie on one line; give points that span a plane")
    result = np.eye(4)
    result[:3, 0] = x / np.linalg.norm(x)
    result[:3, 2] = z / size
    result[:3, 1] = np.cross(result[:3, 2], result[:3, 0])
    result[:3, 3] = placed[:3, 3]
    return result


def precision_point(values: Sequence[float], turns: Sequence[bool] | None = None) -> Array:
    """Return joint values (n,) in rad or m of values in degrees or mm.

    `turns` says of each joint whether it turns, and is told in degrees, or slides, and is told in mm; all turn unless
    it is given. What it does not reach is taken for angles: it does not fit the arm, which is told where it is used.
    """
    given = np.array(_checked(values), dtype=np.float64)
    return given * np.array([joint_unit(turns is None or k >= len(turns) or turns[k]) for k in range(len(given))])


def joint_unit(turns: bool) -> float:
    """Return what one degree of a joint that turns, or one mm of one that slides, is in rad or m."""
    return math.radians(1.0) if turns else _MM


def _checked(values: Sequence[float] | Array) -> Sequence[float] | Array:
    """Return mm or degrees as they are; `ProgramFault` beyond what arithmetic on poses can bear."""
    for value in values:
        if not abs(value) <= _FARTHEST:
            raise ProgramFault(f"{shown(value)} is out of range; mm and degrees go up to 1e6")
    return values


def _cos_sin(degrees: float) -> tuple[float, float]:
    """Return cosine and sine, exact at quarter turns so that `0, 180, 0` points straight down."""
    quarter, rest = divmod(degrees, 90.0)
    if rest == 0.0:
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
    return math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
