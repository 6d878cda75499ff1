"""Castors: how fast one turns about its pivot and rolls while the base moves (Siegwart & Nourbakhsh 3.2.3.3), and back.

Both rates of a castor are its pivot's velocity, along and across: driven ones move the base in any direction at any
angle (Holmberg & Khatib, Development and control of a holonomic mobile robot for mobile manipulation tasks, IJRR 2000).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.errors import InputError
from holonom.mobile.base.protocol import ConstrainedBase
from holonom.mobile.equations.wheels import rolling_row, sliding_row

__all__ = ["CastorRates", "castor_rates", "castor_twist"]

RANK = 1e-9
"""Singular value of the castors' rows, w scaled by the base's radius, below which they leave a motion open."""


class CastorRates(NamedTuple):
    """Of each castor, in the order `names`: turning rate betad and speed of the wheel phid, (..., castors) rad/s."""

    names: tuple[str, ...]
    turning: Array
    rolling: Array


def castor_rates(base: ConstrainedBase, twist: ArrayLike, turned: ArrayLike | None = None) -> CastorRates:
    """Rates at which the castors of a base follow a twist.

    [cos(a+b), sin(a+b), d + l sin(b)] xi + d betad = 0 and [sin(a+b), -cos(a+b), -l cos(b)] xi = r phid.

    Parameters
    ----------
    twist : (..., 3).
    turned : (..., castors) rad, what each has turned from its `beta`; None: nothing.

    Raises
    ------
    ShapeError
    """
    castors = [w for w in base.layout.wheels if w.kind == "castor"]
    xi = vectors("twist", twist, 3)
    angles = np.zeros(len(castors)) if turned is None else vectors("turned", turned, len(castors))
    lead = np.broadcast_shapes(xi.shape[:-1], angles.shape[:-1])
    turning, rolling = np.empty((*lead, len(castors))), np.empty((*lead, len(castors)))
    for k, wheel in enumerate(castors):
        axle: Any = wheel.axle + angles[..., k]
        s, c = np.sin(axle), np.cos(axle)
        turning[..., k] = -_times(sliding_row(wheel.x, wheel.y, s, c), xi) / wheel.castor_offset - xi[..., 2]
        rolling[..., k] = _times(rolling_row(wheel.x, wheel.y, s, c), xi) / wheel.radius
    return CastorRates(tuple(w.name for w in castors), turning, rolling)


def castor_twist(
    base: ConstrainedBase, turning: ArrayLike, rolling: ArrayLike, turned: ArrayLike | None = None
) -> Array:
    """Twist (..., 3) that fits both rates of all castors of a base best, in m/s: `castor_rates` back.

    Parameters
    ----------
    turning, rolling : (..., castors) rad/s, as `castor_rates` gives them.
    turned : (..., castors) rad, what each has turned from its `beta`; None: nothing.

    Raises
    ------
    InputError
        They do not determine the twist: fewer than two castors, or the wheels of all stand on one point.
    ShapeError
    """
    castors = [w for w in base.layout.wheels if w.kind == "castor"]
    k = len(castors)
    found = [vectors(n, v, k) for n, v in (("turning", turning), ("rolling", rolling))]
    angles = np.zeros(k) if turned is None else vectors("turned", turned, k)
    lead = np.broadcast_shapes(angles.shape[:-1], *(v.shape[:-1] for v in found))
    rows, speeds = np.empty((*lead, 2 * k, 3)), np.empty((*lead, 2 * k))
    for i, wheel in enumerate(castors):
        axle: Any = wheel.axle + angles[..., i]
        s, c = np.sin(axle), np.cos(axle)
        for j, row in ((2 * i, sliding_row(wheel.x, wheel.y, s, c)), (2 * i + 1, rolling_row(wheel.x, wheel.y, s, c))):
            for n in range(3):
                rows[..., j, n] = row[n]
        rows[..., 2 * i, 2] += wheel.castor_offset
        speeds[..., 2 * i] = -wheel.castor_offset * found[0][..., i]
        speeds[..., 2 * i + 1] = wheel.radius * found[1][..., i]
    scale = np.array([1.0, 1.0, 1.0 / base.radius])
    rows *= scale
    if k < 2 or np.min(np.linalg.matrix_rank(rows, tol=RANK), initial=3) < 3:
        raise InputError(f"rates of {k} castors do not determine the twist of base {base.name!r}; two apart do")
    return np.asarray((np.linalg.pinv(rows) @ speeds[..., None])[..., 0] * scale)


def _times(row: Any, xi: Array) -> Any:
    return row[0] * xi[..., 0] + row[1] * xi[..., 1] + row[2] * xi[..., 2]
