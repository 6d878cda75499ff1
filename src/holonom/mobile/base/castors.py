"""Castors follow: how fast one turns about its pivot and rolls while the base moves (Siegwart & Nourbakhsh 3.2.3.3)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.mobile.base.protocol import ConstrainedBase
from holonom.mobile.equations.wheels import rolling_row, sliding_row

__all__ = ["CastorRates", "castor_rates"]


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


def _times(row: Any, xi: Array) -> Any:
    return row[0] * xi[..., 0] + row[1] * xi[..., 1] + row[2] * xi[..., 2]
